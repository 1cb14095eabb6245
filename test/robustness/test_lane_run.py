# SPDX-License-Identifier: Apache-2.0
"""Models of other packages that fail in the middle of a run: each is named, in its row or error."""

from typing import NamedTuple

import pytest

from eventreg_ros import judge, load, margins, simulate, sweep
from eventreg_ros.errors import ModelError
from eventreg_ros.models import Model, catalogue, first_state
from eventreg_ros.models.model import ModelParameter
from eventreg_ros.simulation import jit

TABLE = {0: -0.1}


def missing(x, drive, p):
    return (TABLE[0 if x[0] > 0.2 else 7], 0.0)  # and numba knows no such table


def sound(x, drive, p):
    return (TABLE[0], 0.0)


RHS = {'missing': missing, 'sound': sound}


class Gains(NamedTuple):
    gain: float
    pole: float


def leaky(x, drive, p):
    return (p.gain * drive - x[0], x[0] - x[1])


def amplified(x, drive, p):
    return p.gain * x[1] / p.pole


AMPLIFIER = Model(
    'amplifier', 2, leaky, amplified,
    (ModelParameter('gain', 'of it', 1), ModelParameter('pole', 'of it', 1)),
    pack=Gains, x0=(1.0, 0.5),
)  # fmt: skip


class Entry:
    """An entry point of a package."""

    dist = None

    def __init__(self, name):
        self.name, self.value = name, f'strange:{name}'

    def load(self):
        if self.name == 'amplifier':
            return AMPLIFIER
        return Model(self.name, 2, RHS[self.name], first_state, x0=(1.0, 0.0))


@pytest.fixture(autouse=True)
def installed(monkeypatch):
    monkeypatch.setattr(
        catalogue, '_installed', lambda: {name: Entry(name) for name in (*RHS, 'amplifier')}
    )
    catalogue._plugged_in.cache_clear()
    yield
    catalogue._plugged_in.cache_clear()


def using(name):
    return load('exact', {'exosystem.model': name, 'exosystem.x0': [1.0, 0.0]})


@pytest.mark.slow
def test_a_sweep_has_a_row_with_the_reason():
    found = sweep(using('missing'), {'controller.k': [1, 2]}, duration=60.0, settle=10.0)
    assert found.bad == 2
    for reason in found.to_dataframe()['reason']:
        assert reason.startswith("model 'missing' cannot be evaluated: KeyError: 7; fix")


def test_an_output_reads_its_parameters_by_name_and_fails_set_by_set():
    made = load('exact', {'plant.model': 'amplifier', 'plant.x0': [1.0, 0.5]})
    gains = {'plant.gain': [0.5, 2.0], 'plant.pole': [1.0, 0.0]}
    found = sweep(made, gains, duration=150.0, settle=60.0).to_dataframe()
    for i, gain in ((0, 0.5), (2, 2.0)):
        run = simulate(load('exact', {
            'plant.model': 'amplifier', 'plant.x0': [1.0, 0.5], 'plant.gain': gain,
        }), 150.0, sampled=True)  # fmt: skip
        assert found['residual_rms'][i] == judge(run, settle=60.0).residual.rms
    for i in (1, 3):
        assert found['verdict'].isna()[i]
        assert 'output fails at x0 [1.0, 0.5]: ZeroDivisionError' in found['reason'][i]


def test_a_loop_that_diverges_at_once_is_not_called_rejected():
    found = sweep('linear', {'controller.gain[0]': [-3.0, 1.0], 'controller.gain[1]': [2.0, 0.0]})
    rows = found.to_dataframe().itertuples()
    verdicts = {(row[1], row[2]): row.verdict for row in rows}
    assert verdicts[-3.0, 2.0] == 'undecided'
    assert verdicts[1.0, 0.0] == 'rejected'


def test_a_loop_that_diverges_downwards_is_not_called_rejected_either():
    gains = {'controller.gain[0]': [0.0, 1.0], 'controller.gain[1]': [0.0, 3.0]}
    found = sweep('linear', {**gains, 'plant.x0[0]': -1.0}).to_dataframe()
    down = found[found['peak'] < -1e6]
    assert len(down) == 2
    assert (down['spurious'] == 0).all()
    assert down['verdict'].tolist() == ['undecided'] * 2
    assert found['verdict'].tolist()[2] == 'rejected'


@pytest.mark.slow
def test_margins_end_with_its_name():
    with pytest.raises(ModelError, match="model 'missing' cannot be evaluated: KeyError: 7; fix"):
        margins(using('missing'))


@pytest.mark.slow
def test_what_numba_cannot_compile_runs_in_plain_python(monkeypatch):
    pytest.importorskip('numba')
    plain = simulate(using('sound'), 20.0, sampled=True)
    monkeypatch.setattr(jit, 'PAYS', 0)
    again = simulate(using('sound'), 20.0, sampled=True)
    assert (again['y'] == plain['y']).all()
    assert any(part.model.name == 'sound' for parts in jit._refused for part in parts)
    found = sweep(using('sound'), {'controller.k': [1, 2]}, duration=60.0, settle=10.0)
    assert found.undecided == 2
