# SPDX-License-Identifier: Apache-2.0
"""Models of other packages that raise, or return what they must not, at any time: never our fault.

Whatever their code does, a command ends with a verdict or one line, and a model that raised is
named.
"""

import math
import sys

import pytest

from eventreg_ros.models import Model, ModelParameter, catalogue, first_state
from eventreg_ros.simulation import jit

pytestmark = pytest.mark.slow


class SilentError(Exception):
    """Cannot even be printed."""

    def __str__(self):
        raise RuntimeError('no words')


class ModelsOwnError(Exception):
    """Of a kind that nobody knows."""


def endless():
    return endless()


def leave():
    sys.exit(0)


RAISING = {
    'ValueError': lambda: math.sqrt(-1.0),
    'OverflowError': lambda: math.exp(1e3),
    'ZeroDivisionError': lambda: 1.0 / 0.0,
    'KeyError': lambda: {}['a'],
    'TypeError': lambda: 1.0 + 'a',
    'AttributeError': lambda: None.x,
    'StopIteration': lambda: next(iter(())),
    'RecursionError': endless,
    'SystemExit': leave,
}
"""By the name of what it raises."""
ERRORS = [SilentError(), ModelsOwnError('two\n' + 'long ' * 200), RuntimeError(), OSError(2)]
VALUES = [math.nan, math.inf, None, 'a', 1j, (), (1.0,), [1.0, 2.0, 3.0], 10**400, True, object()]
PARTS = ('load', 'pack', 'rhs', 'output', 'confine', 'jacobian')


class EntryPoint:
    """What importlib.metadata gives for a model, with what it loads."""

    value, dist = 'strange:model', None

    def __init__(self, load):
        self.load = load


def a_fault(draw):
    """A function that does something wrong: raises, or returns what it must not."""
    which = draw.random()
    if which < 0.5:
        return RAISING[draw.choice(list(RAISING))]
    if which < 0.7:
        error = draw.choice(ERRORS)

        def raising():
            raise error

        return raising
    value = draw.choice(VALUES)
    return lambda: value


def a_model(draw):
    """A neuron of which a part fails: at once, after some calls, or once the state is large."""
    part, fault = draw.choice(PARTS), a_fault(draw)
    after, large, calls = draw.choice([0, 1, 2, 50]), draw.choice([-9.0, 0.9, 1.5, 9.0]), [0]

    def now(x):
        calls[0] += 1
        return calls[0] > after and (not after or x[0] > large)

    def faulty(name, good):
        return (lambda x, *more: fault() if now(x) else good(x, *more)) if part == name else good

    def rhs(x, drive, p):
        return x[0] - x[0] ** 3 / 3 - x[1] + p[0] * (drive - x[0]), p[1] * (x[0] - x[1])

    def jacobian(x, drive, p):
        return ((1.0 - x[0] ** 2 - p[0], -1.0, p[0]), (p[1], -p[1], 0.0))

    def pack(*numbers):
        return fault() if part == 'pack' else tuple(numbers)

    def load():
        return fault() if part == 'load' else model

    model = Model(
        'strange',
        2,
        faulty('rhs', rhs),
        faulty('output', first_state),
        (ModelParameter('k', 'conductance', 1.0), ModelParameter('tau', 'of the neuron', 1 / 11)),
        pack=pack,
        jacobian=faulty('jacobian', jacobian),
        confine=faulty('confine', lambda x, p: x),
        x0=(0.0, 0.0),
    )
    return load


@pytest.fixture
def offered(monkeypatch):
    """Offer a model as an installed package does."""

    def offer(load):
        catalogue._plugged_in.cache_clear()
        monkeypatch.setattr(catalogue, '_installed', lambda: {'strange': EntryPoint(load)})

    yield offer
    catalogue._plugged_in.cache_clear()


def test_a_model_that_fails(fuzz, answered, offered, monkeypatch, tmp_path):
    monkeypatch.setattr(jit, '_njit', lambda: None)
    monkeypatch.chdir(tmp_path)

    def case(draw):
        offered(a_model(draw))
        role = draw.choice(['exosystem', 'plant', 'plant', 'controller'])
        verb = draw.choice(
            [['simulate', '--duration=20'], ['simulate', '--duration=20', '--sampled']] * 3
            + [['certify', '--time=20'], ['sweep', '-p=plant.k:={1,2}', '--duration=2']]
        )
        model = f'{role}.model:=strange'
        code, lines = answered([verb[0], 'uncontrolled' if role != 'controller' else 'exact',
                                *verb[1:], '-p', model])  # fmt: skip
        if code == 2:
            assert 'model' in lines[-1], lines
        return verb[0], code

    fuzz(40, case)
