# SPDX-License-Identifier: Apache-2.0
"""What colcon and pip install: the nodes where ROS looks for them, eventreg on the path."""

import importlib.util
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from eventreg_ros.scenario.names import KINDS as NODES

ROOT = Path(__file__).resolve().parent.parent
EXECUTABLES = {*NODES, 'eventreg'}
# What is built is built once.
pytestmark = [pytest.mark.slow, pytest.mark.xdist_group('install')]

LAYOUTS = ('', '--merge-install', '--symlink-install')


def tracked():
    """Return the paths of the sources: what git knows, or where there is no git all there is."""
    if (ROOT / '.git').exists():
        listed = run('git', 'ls-files', cwd=ROOT).stdout.splitlines()
        return sorted(name for name in listed if (ROOT / name).exists())
    built = {'build', 'install', 'log', 'dist', '__pycache__'}
    found = (path.relative_to(ROOT) for path in ROOT.rglob('*') if path.is_file())
    return sorted(
        path.as_posix()
        for path in found
        if not any(part in built or part.startswith('.') for part in path.parts)
        and '.egg-info' not in str(path)
        and path.name != 'PKG-INFO'
    )


def run(*command, **options):
    """Run a command and return what became of it."""
    return subprocess.run(command, capture_output=True, text=True, check=False, **options)


def copy_sources(to):
    for name in tracked():
        (to / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, to / name)
    return to


def as_ros2_run_finds(environment):
    """Return the executables of the package by name, looked up as ``ros2 run`` does.

    The prefix comes from the ament index, the executables are the files below lib/PACKAGE that may
    be executed; see get_executable_paths in ros2pkg.
    """
    for prefix in map(Path, environment['AMENT_PREFIX_PATH'].split(os.pathsep)):
        if (prefix / 'share/ament_index/resource_index/packages/eventreg_ros').is_file():
            folder = prefix / 'lib' / 'eventreg_ros'
            return {path.name: path for path in folder.rglob('*') if os.access(path, os.X_OK)}
    raise AssertionError('eventreg_ros is not in the ament index')


def without_ros(folder, environment):
    """Return an environment in which ROS cannot be imported."""
    hide = folder / 'hide'
    hide.mkdir()
    (hide / 'sitecustomize.py').write_text('import sys\nsys.modules.update(rclpy=None)\n')
    return {**environment, 'PYTHONPATH': f'{hide}{os.pathsep}{environment["PYTHONPATH"]}'}


@pytest.fixture(scope='module', params=LAYOUTS, ids=lambda flag: flag.strip('-') or 'plain')
def sourced(request, tmp_path_factory):
    """Build a copy of the package with colcon; return the environment after sourcing it."""
    if importlib.util.find_spec('colcon_core') is None:
        pytest.skip('needs colcon: pip install colcon-common-extensions')
    workspace = tmp_path_factory.mktemp('ws')
    copy_sources(workspace / 'src' / 'eventreg_ros')
    done = run(
        sys.executable, '-m', 'colcon', '--log-base', 'log', 'build',
        *filter(None, [request.param]), cwd=workspace,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    script = '. install/setup.sh && env -0'
    done = run('sh', '-c', script, cwd=workspace, env={**os.environ, 'AMENT_PREFIX_PATH': ''})
    assert done.returncode == 0, done.stderr
    return dict(line.split('=', 1) for line in done.stdout.split('\0') if '=' in line)


@pytest.fixture
def workspace(sourced):
    return Path(sourced['COLCON_PREFIX_PATH'].split(os.pathsep)[0]).parent


def test_sourced_the_command_is_on_the_path_and_runs(sourced, workspace):
    command = shutil.which('eventreg', path=sourced['PATH'])
    assert workspace in Path(command).parents
    done = run(command, 'simulate', 'exact', '--duration', '10', env=sourced, cwd='/')
    assert done.returncode == 3, done.stderr
    assert 'verdict: undecided' in done.stdout
    code = 'import eventreg_ros; print(eventreg_ros.__file__)'
    assert workspace in Path(run(sys.executable, '-c', code, env=sourced, cwd='/').stdout).parents


def test_sourced_ros_finds_every_executable(sourced, workspace):
    found = as_ros2_run_finds(sourced)
    assert set(found) == EXECUTABLES
    assert all(workspace in path.parents for path in found.values())
    done = run(found['plant'], '--help', env=sourced, cwd='/')
    assert (done.returncode, done.stderr) == (0, '')
    assert done.stdout.startswith('usage: plant ')
    done = run(found['eventreg'], 'node', 'nobody', env=sourced, cwd='/')
    assert done.returncode == 2
    assert 'nobody' in done.stderr


def test_share_holds_what_ros_looks_for(sourced):
    share = as_ros2_run_finds(sourced)['plant'].parents[2] / 'share' / 'eventreg_ros'
    assert (share / 'package.xml').read_bytes() == (ROOT / 'package.xml').read_bytes()
    assert (share / 'launch' / 'loop.launch.py').exists()
    shipped = {path.name for path in (ROOT / 'config').iterdir()}
    assert {path.name for path in (share / 'config').iterdir()} == shipped


@pytest.mark.parametrize('arguments', [['plant'], ['eventreg', 'run', 'exact']])
def test_without_ros_an_executable_says_so_in_one_line(sourced, tmp_path, arguments):
    name, *more = arguments
    environment = without_ros(tmp_path, sourced)
    done = run(as_ros2_run_finds(sourced)[name], *more, env=environment, cwd=tmp_path)
    assert done.returncode == 2
    assert len(done.stderr.splitlines()) == 1
    assert 'needs ROS 2' in done.stderr


def build(what, sources, to):
    """Build a wheel or an sdist as pip does, but with this Python's setuptools; return its path."""
    code = f'from setuptools import build_meta; print(build_meta.build_{what}({str(to)!r}))'
    done = run(sys.executable, '-c', code, cwd=sources)
    assert done.returncode == 0, done.stderr
    return to / done.stdout.splitlines()[-1]


@pytest.fixture(scope='module', params=['wheel', 'editable'])
def prefix(request, tmp_path_factory):
    """Install the package with pip into a prefix of its own; return the prefix."""
    setuptools = pytest.importorskip('setuptools')
    if int(setuptools.__version__.split('.')[0]) < 71 and not importlib.util.find_spec('wheel'):
        pytest.skip('needs setuptools 71 or wheel')
    base = tmp_path_factory.mktemp('pip')
    wheel = build(request.param, copy_sources(base / 'src'), base)
    done = run(
        sys.executable, '-m', 'pip', 'install', '--no-index', '--no-deps', '--ignore-installed',
        '--prefix', base / 'prefix', wheel,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return base / 'prefix'


@pytest.fixture
def with_prefix(prefix):
    """The environment in which Python and ROS look into the prefix, the path untouched."""
    site = next(prefix.glob('lib/python*/site-packages'))
    found = site if (site / 'eventreg_ros').exists() else prefix.parent / 'src'  # as its .pth says
    path = f'{found}{os.pathsep}{site}'
    return {**os.environ, 'PYTHONPATH': path, 'AMENT_PREFIX_PATH': str(prefix)}


def test_pip_puts_the_command_alone_on_the_path(prefix, with_prefix):
    assert [path.name for path in (prefix / 'bin').iterdir()] == ['eventreg']
    command = prefix / 'bin' / 'eventreg'
    done = run(command, 'simulate', 'exact', '--duration', '10', env=with_prefix, cwd='/')
    assert done.returncode == 3, done.stderr
    assert (prefix / 'share/eventreg_ros/launch/loop.launch.py').exists()
    assert (prefix / 'share/eventreg_ros/layouts/plotjuggler.xml').exists()


def test_ros_finds_every_executable_that_pip_installed(with_prefix):
    found = as_ros2_run_finds(with_prefix)
    assert set(found) == EXECUTABLES
    assert len({path.read_text() for name, path in found.items() if name in NODES}) == 1
    done = run(found['clock'], '--help', env=with_prefix, cwd='/')
    assert done.stdout.startswith('usage: clock ')
    done = run(found['eventreg'], 'node', 'link', 'there', env=with_prefix, cwd='/')
    assert done.returncode == 2
    assert len(done.stderr.splitlines()) == 1
    assert "link: unknown argument 'there'" in done.stderr


@pytest.fixture(scope='module')
def unpacked(tmp_path_factory):
    """Build the sdist and return the folder that it unpacks to."""
    pytest.importorskip('setuptools')
    base = tmp_path_factory.mktemp('sdist')
    archive = build('sdist', copy_sources(base / 'src'), base)
    shutil.unpack_archive(archive, base)
    return base / archive.name.removesuffix('.tar.gz')


def test_the_sdist_holds_every_source(unpacked):
    packed = {p.relative_to(unpacked).as_posix() for p in unpacked.rglob('*') if p.is_file()}
    missing = sorted(set(tracked()) - packed)
    assert missing == [], 'add them to MANIFEST.in'
    made = {name for name in packed - set(tracked()) if '.egg-info/' not in name}
    assert made == {'PKG-INFO'}
    for name in tracked():
        assert os.access(unpacked / name, os.X_OK) == os.access(ROOT / name, os.X_OK), name


def test_the_tests_run_from_the_unpacked_sdist(unpacked):
    environment = {**os.environ, 'PYTHONPATH': str(unpacked)}
    pytest_ = [sys.executable, '-m', 'pytest', '-q', '-p', 'no:cacheprovider']
    done = run(*pytest_, '--collect-only', cwd=unpacked, env=environment)
    assert done.returncode == 0, done.stdout
    done = run(*pytest_, 'test/test_layering.py', cwd=unpacked, env=environment)
    assert done.returncode == 0, done.stdout
