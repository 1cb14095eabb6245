# SPDX-License-Identifier: Apache-2.0
"""Who may import whom (docs and CONTRIBUTING say it in words); imports inside functions count."""

import ast
import re
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parent.parent / 'eventreg_ros'
NAME = PACKAGE.name

MAY_IMPORT = {
    'errors': '',
    'files': '',
    'interrupts': '',
    'printed': '',
    'models': 'errors',
    'simulation': 'models errors',
    'control': 'simulation models errors',
    'theory': 'control simulation models errors scenario',
    'runtime': 'simulation models errors',
    'scenario': 'runtime control simulation models errors',
    'bags': 'runtime models errors',
    'analysis': 'bags scenario control simulation models errors',
    'robustness': 'theory analysis scenario simulation models errors',
    'plots': 'bags.finding robustness analysis scenario simulation models errors',
    'paper': 'api plots robustness analysis scenario control simulation models errors',
    'nodes': 'runtime control simulation scenario models errors analysis.events analysis.live '
    'bags.writer',
    'session': (
        'nodes.topics nodes.ros nodes.environment plots robustness bags analysis scenario runtime '
        'simulation models errors'
    ),
    'api': 'session paper plots robustness analysis bags scenario theory simulation models errors',
}
"""What each room may import of ours beside itself, by prefix. What is not here may import all but
nodes and cli; cli itself too, except what starts a node."""

GROUND = ('__version__', 'errors', 'files', 'interrupts', 'printed')
"""What everything but these themselves stands on."""

ROS = {
    'rclpy', 'rcl_interfaces', 'rosgraph_msgs', 'std_msgs', 'std_srvs', 'diagnostic_msgs',
    'lifecycle_msgs', 'builtin_interfaces', 'ament_index_python', 'launch', 'launch_ros',
}  # fmt: skip

ONLY_IN = {
    **{name: {'nodes', 'session'} for name in ROS},
    'rosbags': {'bags'},
    'mcap': {'bags'},
    'matplotlib': {'plots'},
}
"""Packages from outside, and the rooms that alone may import them."""

HEAVY = {'scipy', 'matplotlib', 'numba', 'yaml', 'rosbags', 'pandas', 'xarray', 'pyarrow'}


def modules():
    """Return the path of every module by its name in the package ('' for the package itself)."""
    found = {}
    for path in sorted(PACKAGE.rglob('*.py')):
        parts = path.relative_to(PACKAGE).with_suffix('').parts
        found['.'.join(parts[:-1] if parts[-1] == '__init__' else parts)] = path
    return found


def imports(name, path, top_level_only=False):
    """Return the absolute names that a module imports, wherever in the module it does so."""
    tree = ast.parse(path.read_text(encoding='utf-8'))
    package = (NAME, *name.split('.')) if name else (NAME,)
    if path.name != '__init__.py':
        package = package[:-1]
    found = set()
    for node in ast.walk(tree) if not top_level_only else _at_import(tree):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            home = package[: len(package) + 1 - node.level] if node.level else ()
            module = '.'.join((*home, *filter(None, [node.module])))
            found |= {f'{module}.{alias.name}' for alias in node.names}
    return found


def _at_import(tree):
    """Yield the statements that run when the module is imported, except type checkers' ones."""
    pending = list(tree.body)
    while pending:
        node = pending.pop()
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda):
            continue
        if isinstance(node, ast.If) and 'TYPE_CHECKING' in ast.unparse(node.test):
            pending += node.orelse
            continue
        yield node
        pending += ast.iter_child_nodes(node)


def within(name, part):
    return name == part or name.startswith(part + '.')


def violations():
    """Yield (module, import) for each import against the arrows."""
    for name, path in modules().items():
        part = name.partition('.')[0]
        for full in imports(name, path):
            outside = full.partition('.')[0]
            if outside == NAME:
                own = full.partition('.')[2]
                if own and not allowed(name, part, own):
                    yield name, full
            elif part not in ONLY_IN.get(outside, {part}):
                yield name, full


def allowed(name, part, own):
    if within(own, 'cli'):
        return part == 'cli' or name == '__main__'
    if own.partition('.')[0] in GROUND and part not in ('errors', 'interrupts'):
        return True
    if part in MAY_IMPORT:
        return any(within(own, prefix) for prefix in (part, *MAY_IMPORT[part].split()))
    return not within(own, 'nodes') or (part == 'cli' and within(own, 'nodes.executables'))


@pytest.mark.slow
def test_no_import_goes_against_the_arrows():
    assert sorted(violations()) == []


def test_contributing_says_the_same():
    text = (PACKAGE.parent / 'CONTRIBUTING.md').read_text(encoding='utf-8')
    rows = re.findall(r'^\| `(\w+)(?:/|\.py)` \|[^|]+\| ([^|]+) \|$', text, re.MULTILINE)
    said = {room: set(may.split(', ')) - {'nothing'} for room, may in rows if room != 'cli'}
    ground = set(GROUND)
    meant = {room: set(may.split()) - ground for room, may in MAY_IMPORT.items()}
    assert said == {room: may for room, may in meant.items() if room not in ground}
    rooms = {path.name for path in PACKAGE.iterdir() if (path / '__init__.py').exists()}
    assert rooms == {room for room, _ in rows} - {'api'}


def test_every_part_that_is_meant_exists():
    names = modules()
    for part in (*MAY_IMPORT, 'cli', *set().union(*ONLY_IN.values())):
        assert part in names


@pytest.mark.parametrize('folder', ['launch', 'docs', 'examples', 'bench'])
def test_nobody_outside_the_package_imports_the_command(folder):
    found = {
        (path.name, full)
        for path in sorted((PACKAGE.parent / folder).rglob('*.py'))
        for full in imports('outside', path)
        if within(full, f'{NAME}.cli')
    }
    assert found == set()


@pytest.mark.parametrize(
    ('name', 'source', 'found'),
    [
        ('models.x', 'from ..simulation import step', 'eventreg_ros.simulation.step'),
        ('models.x', 'def f():\n  from ..simulation.step import make_step', 'make_step'),
        ('models.x', 'import eventreg_ros.scenario', 'eventreg_ros.scenario'),
        ('analysis.x', 'if T:\n  from ..simulation import grid', 'eventreg_ros.simulation.grid'),
        ('cli.x', 'try:\n  import rclpy.node\nexcept ImportError: ...', 'rclpy.node'),
    ],
)
def test_imports_are_found_wherever_they_stand(tmp_path, name, source, found):
    path = tmp_path / 'x.py'
    path.write_text(source)
    assert any(full.endswith(found) for full in imports(name, path))


@pytest.mark.parametrize(
    ('name', 'own', 'verdict'),
    [
        ('models.x', 'simulation.step.make_step', False),
        ('simulation.x', 'models.neuron', True),
        ('simulation.x', 'scenario', False),
        ('runtime.x', 'bags.reader', False),
        ('analysis.x', 'nodes.block', False),
        ('nodes.x', 'analysis.events.detect', True),
        ('nodes.x', 'analysis.verdict', False),
        ('nodes.x', 'cli.main', False),
        ('session.x', 'nodes.topics', True),
        ('session.x', 'nodes.block', False),
        ('cli.x', 'nodes.block.BlockNode', False),
        ('cli.x', 'nodes.executables.run', True),
        ('plots.x', 'nodes.executables.run', False),
        ('scenario.x', 'cli.main', False),
        ('scenario.x', 'nodes.block', False),
        ('scenario.parameters', 'simulation.hold', True),
        ('__main__', 'cli.main', True),
    ],
)
def test_the_arrows_themselves(name, own, verdict):
    assert allowed(name, name.partition('.')[0], own) is verdict


@pytest.mark.slow
def test_heavy_packages_are_imported_where_they_are_used():
    found = {
        (name, full)
        for name, path in modules().items()
        for full in imports(name, path, top_level_only=True)
        if full.partition('.')[0] in HEAVY
    }
    assert found == set()


def test_importing_the_package_costs_nothing(python):
    result = python('-c', 'import eventreg_ros, sys; print(*sys.modules)')
    loaded = {name.partition('.')[0] for name in result.stdout.split()}
    assert 'eventreg_ros' in loaded
    assert not loaded & {*HEAVY, *ROS, 'numpy'}


def test_help_costs_little(python):
    code = (
        'import sys; sys.argv = ["eventreg", "--help"]\n'
        'from eventreg_ros.cli.main import main\n'
        'try: main()\nexcept SystemExit: print(*sys.modules)'
    )
    loaded = {name.partition('.')[0] for name in python('-c', code).stdout.split()}
    assert 'eventreg_ros' in loaded
    assert not loaded & {*HEAVY, *ROS, 'numpy'}
