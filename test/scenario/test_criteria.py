# SPDX-License-Identifier: Apache-2.0
"""The numbers that a verdict rests on: their defaults and their rules."""

import dataclasses
import math

import pytest

from eventreg_ros.errors import ParameterError
from eventreg_ros.models.neuron import FOLD
from eventreg_ros.scenario.criteria import Criteria


def test_the_contracts_defaults():
    assert dataclasses.asdict(Criteria()) == {
        'threshold': FOLD, 'reset': 0.0, 'settle': 100.0, 'window': 5.0, 'blind': 5.0,
        'refractory': 0.0, 'min_width': 0.0,
    }  # fmt: skip
    assert Criteria(1.5, -1.0, refractory=3.0, min_width=2.0).detector == (1.5, -1.0, 3.0, 2.0)


@pytest.mark.parametrize(
    ('name', 'value', 'rule'),
    [
        ('threshold', math.nan, 'reset must be < threshold'),
        ('threshold', math.inf, 'threshold must be finite'),
        ('reset', 1.0, 'reset must be < threshold'),
        ('reset', -math.inf, 'reset must be finite'),
        ('settle', -1.0, 'settle must be finite and >= 0'),
        ('window', math.inf, 'window must be finite and >= 0'),
        ('blind', 0.0, 'blind must be finite and > 0'),
        ('refractory', -1e-9, 'refractory must be finite and >= 0'),
        ('min_width', math.nan, 'min_width must be finite and >= 0'),
    ],
)
def test_a_bad_value_is_refused_in_one_line(name, value, rule):
    with pytest.raises(ParameterError, match=rule) as caught:
        Criteria(**{name: value})
    assert '\n' not in str(caught.value)
