# SPDX-License-Identifier: Apache-2.0
"""Machine code that is kept: found again, never the wrong one, and never in the way."""

import os
from types import ModuleType

import numpy as np
import pytest

from eventreg_ros.simulation import code_cache
from eventreg_ros.simulation.code_cache import compile_kept, fingerprint, generated, is_kept

pytestmark = pytest.mark.slow

ONE = """
from eventreg_ros import load
from eventreg_ros.simulation import jit
from eventreg_ros.simulation.sampled import SampledLoop
run = SampledLoop(load('uncontrolled').loop).run(10.0, compiled=True)
print(run.signals['y'].tobytes().hex()[-64:])
kernels = list(jit._compiled.values())
"""
LANES = """
from eventreg_ros import load
from eventreg_ros.robustness import lane_counts
from eventreg_ros.robustness.plan import Plan
from eventreg_ros.robustness.sets import Sets
from eventreg_ros.simulation import lanes
plan = Plan.of(load('uncontrolled'), ['exosystem.tau:={0.05,0.1}', '/**.rate:=50'], duration=200.0)
print(Sets(plan).run(plan.design.columns(0, 2)).rows['residual_rms'].tolist())
structure = lanes.structure_of(load('uncontrolled').loop, ['w', 'y'], 'perfect')
kernels = [lanes.compiled_with(structure, lane_counts.take)]
"""
HITS = """
for kernel in kernels:
    print(sum(getattr(kernel, 'function', kernel).stats.cache_hits.values()))
"""


@pytest.fixture
def run(spawn):
    """Run a piece of code above in a process with that cache directory; return what it prints."""
    pytest.importorskip('numba')

    def start(code, directory):
        environment = {**os.environ, 'NUMBA_CACHE_DIR': str(directory)}
        out, err = spawn('-c', code + HITS, env=environment).communicate(timeout=120)
        assert err == ''
        numbers, hits = out.splitlines()
        return numbers, int(hits)

    return start


@pytest.mark.parametrize('code', [ONE, LANES], ids=['one', 'lanes'])
def test_the_next_process_compiles_nothing_and_gets_the_same(run, tmp_path, code):
    first, hits = run(code, tmp_path)
    assert hits == 0
    assert run(code, tmp_path) == (first, 1)


def test_a_broken_file_or_a_directory_that_cannot_be_written_is_no_trouble(run, tmp_path):
    first, _ = run(ONE, tmp_path)
    for file in tmp_path.rglob('*.nbc'):
        file.write_bytes(b'broken')
    (tmp_path / 'file').touch()
    for directory in (tmp_path, tmp_path / 'file' / 'cache'):
        assert run(ONE, directory) == (first, 0)


def test_it_is_known_what_was_compiled_before(monkeypatch, tmp_path):
    numba = pytest.importorskip('numba')
    monkeypatch.setenv('NUMBA_CACHE_DIR', str(tmp_path))
    one, other = (generated(f'def f(x):\n    return x + {n}.0\n', 'f', {}) for n in (1, 2))
    assert not is_kept(one)
    assert compile_kept(numba.njit, one)(1.0) == 2.0
    assert is_kept(one)
    assert not is_kept(other)


def helper(constant):
    def inner(x):
        return x + constant

    def outer(x):
        return inner(x) * 2.0

    return outer


def test_a_fingerprint_is_of_all_that_is_called():
    assert fingerprint(helper(1.0)) == fingerprint(helper(1.0))
    assert fingerprint(helper(1.0)) != fingerprint(helper(2.0))
    source = 'def f(x):\n    return g(x)\n'
    one, other = (generated(source, 'f', {'g': helper(each)}) for each in (1.0, 2.0))
    assert fingerprint(one) != fingerprint(other)
    assert one(1.0) == 4.0
    assert fingerprint(helper(0.0)) != fingerprint(helper(-0.0))


def test_the_directory_is_the_users(monkeypatch, tmp_path):
    monkeypatch.delenv('NUMBA_CACHE_DIR', raising=False)
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path))
    monkeypatch.setattr(code_cache.sys, 'platform', 'linux')
    assert code_cache.directory() == tmp_path / 'eventreg_ros'
    monkeypatch.setenv('NUMBA_CACHE_DIR', str(tmp_path / 'n'))
    assert code_cache.directory() == tmp_path / 'n' / 'eventreg_ros'


SOURCES = {
    'an array': 'def f(x):\n    return x * HELD[0]',
    'of a module': 'def f(x):\n    return x * constants.GAIN',
    'of a module in a module': 'def f(x):\n    return x * package.constants.GAIN',
    'in a comprehension': 'def f(x):\n    return sum([x * constants.GAIN for i in (0, 1)])',
}


@pytest.mark.parametrize('source', SOURCES.values(), ids=SOURCES)
def test_a_fingerprint_is_of_the_constants_that_numba_takes_in(source):
    def of(gain):
        constants, package = ModuleType('constants'), ModuleType('package')
        constants.GAIN, package.constants = gain, constants
        held = np.array([gain, 1.0])
        names = {'HELD': held, 'constants': constants, 'package': package, 'np': np}
        return fingerprint(generated(source, 'f', names))

    assert of(1.0) == of(1.0)
    assert of(1.0) != of(2.0)


def test_a_fingerprint_may_be_of_numpys_types():
    assert fingerprint(generated('def f(x):\n    return np.float64(x) * np.pi', 'f', {'np': np}))
