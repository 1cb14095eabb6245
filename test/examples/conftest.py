# SPDX-License-Identifier: Apache-2.0
"""The examples, installed as colcon does it, under a prefix of their own."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope='module')
def installed(tmp_path_factory):
    """Install an example by its name; return how to run this Python with it."""

    def install(name):
        work = tmp_path_factory.mktemp(name)
        source, prefix = work / 'source', work / 'prefix'
        shutil.copytree(ROOT / 'examples' / name, source)
        setup = [sys.executable, '-W', 'ignore', 'setup.py', '-q', 'install', '--prefix', prefix]
        setup += ['--single-version-externally-managed', '--record', work / 'record.txt']
        subprocess.run(setup, cwd=source, check=True, capture_output=True, text=True)
        (packages,) = prefix.glob('lib/python*/site-packages')
        environment = {
            **os.environ,
            'PYTHONPATH': os.pathsep.join([str(packages), str(ROOT)]),
            'AMENT_PREFIX_PATH': str(prefix),
        }
        environment.pop('ROS_DOMAIN_ID', None)

        def run(*arguments, code=0):
            found = subprocess.run(
                [sys.executable, *map(str, arguments)],
                env=environment, cwd=work, capture_output=True, text=True, timeout=120,
            )  # fmt: skip
            assert found.returncode == code, found.stdout + found.stderr
            return found

        run.work = work
        return run

    return install
