# SPDX-License-Identifier: Apache-2.0
"""What certify says of a controller that learns, and of its gain k."""

import pytest

from eventreg_ros import load
from eventreg_ros.control.adaptive import fixed
from eventreg_ros.theory.adaptation import gain_and_delay, learning
from eventreg_ros.theory.averaging import learning_rate
from eventreg_ros.theory.certificates import internal_model


def certificate(*overrides, name='exact'):
    blocks = load(name, 'controller.adapt:=0.04', *overrides).loop.blocks
    return learning(blocks['controller'], [b for b in blocks.values() if b.role == 'exosystem'])


def test_it_learns_at_the_predicted_rate():
    found = certificate()
    assert found.status == 'pass'
    assert found.value == pytest.approx(learning_rate(1 / 12, 0.04))
    assert 'goes to its upper bound 1.5, where the oscillator dies out' in found.text
    assert 'and stays there' in certificate('controller.tau_max:=0.9').text


def test_beyond_what_converges_it_warns():
    found = certificate('controller.adapt:=0.16')
    assert found.status == 'none'
    assert 'Above 0.08 it need not converge' in found.text
    assert certificate('controller.adapt:=0.08').status == 'pass'


def test_a_generator_out_of_its_bounds_cannot_be_learned():
    found = certificate('controller.tau_max:=0.09', 'exosystem.tau:=0.1')
    assert found.status == 'fail'
    assert 'exosystem is outside of 0.02..0.09' in found.text
    alone = certificate(name='quiescent')
    assert (alone.status, alone.value) == ('none', None)
    assert 'No generator of its kind' in alone.text


def test_a_controller_that_learns_is_to_become_a_copy():
    blocks = load('mismatch', 'controller.adapt:=0.04').loop.blocks
    (found,) = internal_model(blocks['controller'], blocks['exosystem'])
    assert found.status == 'pass'
    assert 'tau by -25 %' in found.text
    assert 'learns tau' in found.text
    assert fixed(blocks['controller']) == load('mismatch').loop.blocks['controller']


def test_gain_against_delay():
    def of(*overrides):
        blocks = load('exact', *overrides).loop.blocks
        return gain_and_delay(blocks['controller'], blocks['plant'], None)

    # measured by eventreg margin, zero hold: docs/which_k.md
    for k, measured in ((0.7, 0.76), (1.0, 0.7), (2.0, 0.38), (4.0, 0.2), (8.0, 0.1)):
        assert 0.79 < measured / of(f'controller.k:={k}').value < 1.0
    assert 'no event passes' in of('controller.k:=2').text
    assert 'a wrong tau lets events pass' in of('controller.k:=1').text
    assert 'a small k is enough' in of('controller.k:=1', 'controller.adapt:=0.04').text
    assert of('controller.k:=0') is None
    assert of('controller.tau:=1.2') is None
    large = [each * of(f'controller.k:={each}').value for each in (100.0, 1000.0)]
    assert large == pytest.approx([1.08, 1.08], abs=0.03), '(a + 1/4) / k with a = 0.834'
    assert gain_and_delay(load('linear').loop.blocks['controller'], None, None) is None
