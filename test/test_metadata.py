# SPDX-License-Identifier: Apache-2.0
"""What setup.py, package.xml and CITATION.cff say: that they agree, and name all that is needed."""

import ast
import re
import runpy
import sys
from pathlib import Path

import pytest
import yaml

from eventreg_ros import __version__

ROOT = Path(__file__).resolve().parent.parent

PYPI_AND_ROSDEP = {
    'numpy': ('numpy', 'python3-numpy'),
    'scipy': ('scipy', 'python3-scipy'),
    'matplotlib': ('matplotlib', 'python3-matplotlib'),
    'yaml': ('PyYAML', 'python3-yaml'),
    'rosbags': ('rosbags', 'python3-rosbags-pip'),
    'lz4': ('lz4', 'python3-rosbags-pip'),
    'backports': ('backports.zstd', 'python3-rosbags-pip'),
}
"""What the package cannot do without, by import: its names on PyPI and for rosdep."""

COMES_WITH_NUMBA = {'llvmlite'}

EXTRAS = {
    'numba': 'fast',
    'pandas': 'frames',
    'xarray': 'frames',
    'pyarrow': 'frames',
    'SALib': 'indices',
    'distributed': 'cluster',
    'argcomplete': 'completion',
    'foxglove': 'live',
}
"""What some of the package can do without, by import: the extra that brings it."""

PYPI = {'foxglove': 'foxglove-sdk'}
"""Names on PyPI of those that are called otherwise there."""

NOT_IMPORTED = {'ros2launch'}
"""What README uses and no file imports."""

FROM_ROS = {'launch_pytest'}
"""What only tests on ROS machines import."""

STANDARD = {*sys.stdlib_module_names, 'compression'}  # the latter from Python 3.14 on


@pytest.fixture(scope='module')
def manifest():
    catkin_package = pytest.importorskip('catkin_pkg.package')
    warnings = []
    found = catkin_package.parse_package(str(ROOT / 'package.xml'), warnings=warnings)
    found.validate(warnings=warnings)
    assert warnings == []
    return found


@pytest.fixture(scope='module')
def setup():
    """The arguments that setup.py gives to setuptools."""
    setuptools = pytest.importorskip('setuptools')
    given = {}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(setuptools, 'setup', given.update)
        runpy.run_path(str(ROOT / 'setup.py'))
    return given


@pytest.fixture(scope='module')
def citation():
    return yaml.safe_load((ROOT / 'CITATION.cff').read_text(encoding='utf-8'))


def requirements(lines):
    """Return the constraint of each requirement by its name on PyPI."""
    return dict(re.fullmatch(r'([\w.-]+)([^;]*)(?:;.*)?', line).groups() for line in lines)


def imported(*folders):
    """Return what the folders import that is neither the standard library's nor ours."""
    paths = [path for folder in folders for path in (ROOT / folder).rglob('*.py')]
    names = {name.partition('.')[0] for path in paths for name in _imports(path)}
    scripts = {path.stem for folder in ('bench', 'docs') for path in (ROOT / folder).glob('*.py')}
    return names - scripts - {'eventreg_ros'} - STANDARD


def _imports(path):
    for node in ast.walk(ast.parse(path.read_text(encoding='utf-8'))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and not node.level:
            yield node.module


def test_name_version_licence_and_people_agree(manifest, setup, citation):
    assert manifest.name == setup['name'] == 'eventreg_ros'
    assert manifest.version == setup['version'] == citation['version'] == __version__
    assert manifest.licenses == [setup['license']] == [citation['license']] == ['Apache-2.0']
    assert manifest.get_build_type() == 'ament_python'
    for people in (manifest.authors, manifest.maintainers):
        assert [(p.name, p.email) for p in people] == [(setup['author'], setup['author_email'])]
    assert (setup['maintainer'], setup['maintainer_email']) == (
        setup['author'],
        setup['author_email'],
    )
    assert [url.url for url in manifest.urls] == [setup['url']]
    assert citation['references'][0]['url'] == setup['url']


def test_whoever_reads_the_index_finds_what_it_is(setup):
    assert setup['long_description'] == (ROOT / 'README.md').read_text(encoding='utf-8')
    assert setup['keywords']
    assert 'Programming Language :: Python :: 3.10' in setup['classifiers']
    assert setup['python_requires'] == '>=3.10'


@pytest.mark.slow
def test_all_that_the_package_imports_is_declared_and_nothing_else(manifest, setup):
    names = imported('eventreg_ros', 'launch') - set(EXTRAS) - COMES_WITH_NUMBA
    keys = {PYPI_AND_ROSDEP[name][1] if name in PYPI_AND_ROSDEP else name for name in names}
    assert {d.name for d in manifest.exec_depends} == keys | NOT_IMPORTED
    assert set(requirements(setup['install_requires'])) == {
        pip for pip, _ in PYPI_AND_ROSDEP.values()
    }
    for name, extra in EXTRAS.items():
        assert PYPI.get(name, name) in requirements(setup['extras_require'][extra])


def test_every_dependency_has_a_lower_bound_and_rosbags_an_upper_one(setup):
    everywhere = requirements(setup['install_requires'])
    optional = [requirements(lines) for lines in setup['extras_require'].values()]
    for bounds in (everywhere, *optional):
        loose = {name for name, bound in bounds.items() if '>=' not in bound and '==' not in bound}
        assert loose == set()
    assert '<' in everywhere['rosbags']


@pytest.mark.slow
def test_what_the_tests_import_is_declared(manifest, setup):
    needed = imported('test') - set(PYPI_AND_ROSDEP) - set(EXTRAS) - FROM_ROS
    ros = {d.name for d in manifest.exec_depends}
    assert {d.name for d in manifest.test_depends} >= FROM_ROS
    rosdep = {'python3-' + {'catkin_pkg': 'catkin-pkg-modules'}.get(n, n) for n in needed - ros}
    assert rosdep <= {d.name for d in manifest.test_depends}
    pip = requirements([*setup['extras_require']['test'], 'catkin_pkg'])  # which colcon brings
    assert needed - ros <= set(pip)


def test_the_readme_says_what_each_extra_is_for(setup):
    text = (ROOT / 'README.md').read_text(encoding='utf-8')
    assert [extra for extra in setup['extras_require'] if f'| `{extra}` |' not in text] == []
