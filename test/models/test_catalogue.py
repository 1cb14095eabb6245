# SPDX-License-Identifier: Apache-2.0
"""Models of installed packages: what is wrong with one is an error that names it."""

import pytest

from eventreg_ros.errors import EventregError, ModelError
from eventreg_ros.models import catalogue
from eventreg_ros.scenario.parameters import resolve

CODE = """
import math
from eventreg_ros.models import Model, ModelParameter, first_state

def model(name, rhs, output=first_state, x0=(1.0, 0.0)):
    return Model(name, 2, rhs, output, (ModelParameter('mu', 'stiffness', 4.0),), x0=x0)

fine = model('fine', lambda x, drive, p: (math.sqrt(p[0]) - x[0], drive))
short = model('short', lambda x, drive, p: (1.0,))
raising = model('raising', lambda x, drive, p: (math.exp(1e3 * x[0]), 0.0))
pair = model('pair', fine.rhs, lambda x, drive, p: x)
long_x0 = model('long_x0', fine.rhs, x0=(1.0, 0.0, 0.0))
"""
NAMES = ('fine', 'short', 'raising', 'pair', 'long_x0')


@pytest.fixture
def install(tmp_path, monkeypatch):
    """Return how to install a package that offers models of these names."""

    def clear():
        catalogue._installed.cache_clear()
        catalogue._plugged_in.cache_clear()

    def offer(**models):
        (tmp_path / 'strange_models.py').write_text(CODE)
        info = tmp_path / 'strange-1.0.dist-info'
        info.mkdir()
        (info / 'METADATA').write_text('Metadata-Version: 2.1\nName: strange\nVersion: 1.0\n')
        lines = [f'{name} = strange_models:{attribute}' for name, attribute in models.items()]
        (info / 'entry_points.txt').write_text('\n'.join([f'[{catalogue.GROUP}]', *lines]))
        monkeypatch.syspath_prepend(tmp_path)
        clear()

    yield offer
    monkeypatch.undo()
    clear()


@pytest.mark.parametrize(
    ('model', 'words'),
    [
        ('short', 'rhs must return 2 numbers, its dimension, got 1'),
        ('raising', 'rhs fails at x0 [1.0, 0.0]: OverflowError: math range error'),
        ('pair', 'output fails at x0 [1.0, 0.0]: TypeError'),
        ('long_x0', 'x0 must have 2 numbers, its dimension, got 3'),
    ],
)
def test_what_is_wrong_with_a_model_names_it_and_its_package(install, model, words):
    install(**{name: name for name in NAMES})
    with pytest.raises(EventregError) as caught:
        resolve('exosystem', {'model': model})
    assert f"model '{model}' (strange_models:{model} of package strange)" in str(caught.value)
    assert words in str(caught.value)


def test_it_is_tried_with_the_values_that_are_given(install):
    install(fine='fine')
    assert resolve('plant', {'model': 'fine'})['mu'] == 4.0
    with pytest.raises(EventregError, match=r'rhs fails at x0 .* ValueError'):
        resolve('plant', {'model': 'fine', 'mu': -1.0})


def test_the_name_of_a_built_in_model_is_refused(install):
    install(neuron='fine')
    with pytest.raises(ModelError, match=r"'neuron' \(strange_models:fine of package strange\)"):
        catalogue.model_of('plant', 'neuron')
    assert catalogue.model_of('plant', 'morris_lecar').name == 'morris_lecar'
