# SPDX-License-Identifier: Apache-2.0
"""The code of another package's model, compiled, against the same code in plain Python."""

import math
import random
from dataclasses import replace
from math import gamma
from unittest.mock import Mock

import numpy as np
import pytest

from eventreg_ros import scenario
from eventreg_ros.analysis.subject import subject_of
from eventreg_ros.models import Model, ModelParameter, first_state
from eventreg_ros.robustness.lane_run import run
from eventreg_ros.robustness.outcome import Case, one_by_one
from eventreg_ros.simulation import jit, same_bits
from eventreg_ros.simulation.impairment import PERFECT

pytestmark = pytest.mark.slow


@pytest.fixture
def compile():
    """Compile a function of another package, so that Python can call it."""
    numba = pytest.importorskip('numba')
    from eventreg_ros.simulation.jit import inliner

    def compiled(function):
        inner = inliner()(function)
        return numba.njit(error_model='numpy')(lambda x: inner(x))

    return compiled


def value(function, x):
    """Return what Python makes of it, NaN where it raises or leaves the real numbers."""
    try:
        found = function(x)
    except (ArithmeticError, ValueError):
        return math.nan
    return math.nan if isinstance(found, complex) else float(found)


def cube_in_place(x):
    y = x
    y **= 3
    y /= 0.3
    return y


@pytest.mark.parametrize(
    'function',
    [
        lambda x: x**3 + x**2 + x**-4,
        lambda x: abs(x) ** 0.5 + x**1.5 + 2**x,
        lambda x: pow(x, 3) + math.pow(x, 2) + math.pow(2.0, x),
        lambda x: 1.0 / (1.0 + math.exp(-400.0 * x)),
        lambda x: 1.0 / (1.0 + 1.0 / (x - x)),
        lambda x: 1.0 / (1.0 + math.log(abs(x) - abs(x))),
        lambda x: x // 0.3 + x % 0.7 + 7 % x + cube_in_place(x),
        lambda x: math.tanh(x) + math.atan2(x, 0.3) + np.sqrt(abs(x)) * np.pi,
        lambda x: sum([n**-2 * math.sin(n * x) for n in (1, 2, 3)]) + int(x) ** 3,
        lambda x: int(1e19 * x) + math.floor(x) + math.ceil(x) // 2 + round(x) + round(x, 1),
        lambda x: math.floor(1e300 * x) % 7.0 + math.copysign(1.0, np.sign(-0.0 * x)),
        lambda x: 1.0 / (1.0 + math.trunc(1e308 * x * 10.0)),
    ],
)
def test_numbers_are_pythons_to_the_last_bit(compile, function):
    compiled, draw = compile(function), random.Random(1)
    for _ in range(3000):
        x = draw.uniform(-4.0, 4.0)
        assert np.array_equal(value(function, x), compiled(x), equal_nan=True), x


@pytest.mark.parametrize(
    'function',
    [
        lambda x: np.tanh(x),
        lambda x: math.hypot(x, 1.0),
        lambda x: gamma(x),
        lambda x: math.lgamma(x),
        lambda x: math.ldexp(x, 2000),
    ],
)
def test_what_cannot_be_the_same_is_refused(compile, function):
    from numba.core.errors import NumbaError

    with pytest.raises(NumbaError, match='other bits than in Python'):
        compile(function)(0.5)


def _cubic(x, drive, p):
    return (x[0] - x[0] ** 3 / 3.0 - x[1] + p[0] * drive, (x[0] + 0.7 - 0.8 * x[1]) * p[1])


def _numpy(x, drive, p):
    return (np.tanh(3.0 * x[0]) - x[0] - x[1] + p[0] * drive, (x[0] - x[1]) * p[1])


def _case(rhs):
    """Return a run of the exact loop with a plant of another package."""
    parameters = (ModelParameter('k', '', 1.0), ModelParameter('tau', '', 0.1))
    model = Model('own', 2, rhs, first_state, parameters, x0=(0.1, 0.0))
    loop = scenario.load('exact', ['/**.rate:=50']).loop
    plant = replace(loop.blocks['plant'], model=model, params=(1.0, 0.1), x0=(0.1, 0.0))
    loop = replace(loop, blocks={**loop.blocks, 'plant': plant})
    subject = subject_of(scenario.load('exact', ['spike_monitor.settle:=20']), loop.signals)
    return Case(loop, PERFECT, subject, 80.0)


@pytest.mark.parametrize('rhs', [_cubic, _numpy])
def test_a_model_with_powers_or_numpy_has_the_same_bits_everywhere(rhs):
    pytest.importorskip('numba')
    case = _case(rhs)
    by_python = one_by_one(case).row  # too short to be compiled
    assert run([case] * 2).rows.tobytes() == 2 * by_python.tobytes()


@pytest.mark.parametrize('part', ['replacements', '_replace'])
def test_with_a_numba_that_is_another_one_inside_models_run_in_plain_python(monkeypatch, part):
    pytest.importorskip('numba')
    case = _case(lambda x, drive, p: _cubic(x, drive, p))  # known to no cache
    by_python = one_by_one(case)
    same_bits.pipeline.cache_clear()
    asked = Mock(side_effect=AttributeError('not there'))
    monkeypatch.setattr(same_bits, part, asked)
    monkeypatch.setattr(jit, 'PAYS', 0)
    again = one_by_one(case)
    assert (again.row.tobytes(), again.reason) == (by_python.row.tobytes(), '')
    assert asked.called
    assert run([case] * 2).rows.tobytes() == 2 * by_python.row.tobytes()
