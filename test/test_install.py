"""What colcon installs: every executable, share/ and the marker of the ament index."""

import importlib.util
import os
import re
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from eventreg_ros import __version__
from eventreg_ros.scenario.names import KINDS as NODES

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope='module')
def installed(tmp_path_factory):
    """Build a copy of the package with colcon; return install/eventreg_ros."""
    if importlib.util.find_spec('colcon_core') is None:
        pytest.skip('needs colcon: pip install colcon-common-extensions')
    base = tmp_path_factory.mktemp('ws')
    wanted = ('package.xml', 'setup.py', 'setup.cfg', 'README.md', 'LICENSE')
    (base / 'src').mkdir()
    for name in wanted:
        shutil.copy(ROOT / name, base / 'src')
    for name in ('eventreg_ros', 'config', 'launch', 'resource'):
        ignored = shutil.ignore_patterns('__pycache__')
        shutil.copytree(ROOT / name, base / 'src' / name, ignore=ignored)
    done = subprocess.run(
        [sys.executable, '-m', 'colcon', '--log-base', 'log', 'build'],
        cwd=base, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return base / 'install' / 'eventreg_ros'


def test_every_executable_is_there_and_runs(installed):
    executables = {path.name for path in (installed / 'lib' / 'eventreg_ros').iterdir()}
    assert executables == {*NODES, 'eventreg'}
    site = next(installed.glob('lib/python*/site-packages'))
    environment = {**os.environ, 'PYTHONPATH': str(site)}
    done = subprocess.run(
        [installed / 'lib' / 'eventreg_ros' / 'eventreg', 'simulate', 'exact', '--duration', '10'],
        env=environment, capture_output=True, text=True, check=False, cwd=installed,
    )  # fmt: skip
    assert done.returncode == 3, done.stderr
    assert 'verdict: undecided' in done.stdout


@pytest.mark.parametrize('arguments', [['plant'], ['eventreg', 'run', 'exact']])
def test_without_ros_it_says_so_in_one_line(installed, tmp_path, arguments):
    site = next(installed.glob('lib/python*/site-packages'))
    hide = tmp_path / 'sitecustomize.py'  # as on a machine where rclpy is not installed
    hide.write_text('import sys\nsys.modules.update(rclpy=None, std_msgs=None)\n')
    done = subprocess.run(
        [installed / 'lib' / 'eventreg_ros' / arguments[0], *arguments[1:]],
        env={**os.environ, 'PYTHONPATH': f'{tmp_path}:{site}'},
        capture_output=True, text=True, check=False, cwd=tmp_path,
    )  # fmt: skip
    assert done.returncode == 2
    assert len(done.stderr.splitlines()) == 1
    assert 'needs ROS 2' in done.stderr


def test_share_holds_what_ros_looks_for(installed):
    share = installed / 'share'
    assert (share / 'ament_index/resource_index/packages/eventreg_ros').exists()
    ours = share / 'eventreg_ros'
    assert (ours / 'package.xml').exists()
    assert (ours / 'launch' / 'loop.launch.py').exists()
    shipped = {path.name for path in (ROOT / 'config').iterdir()}
    assert {path.name for path in (ours / 'config').iterdir()} == shipped


def test_the_manifest_the_setup_and_the_module_agree():
    manifest = ET.parse(ROOT / 'package.xml').getroot()
    setup = (ROOT / 'setup.py').read_text()
    assert manifest.get('format') == '3'
    assert manifest.findtext('name') == 'eventreg_ros'
    assert manifest.findtext('license') == 'Apache-2.0'
    assert manifest.findtext('version') == __version__
    assert re.search(r"version='([^']*)'", setup).group(1) == __version__
    assert manifest.findtext('export/build_type') == 'ament_python'
