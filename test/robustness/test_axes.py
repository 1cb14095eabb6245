# SPDX-License-Identifier: Apache-2.0
"""What may follow -p in a sweep, and the values that it means."""

import numpy as np
import pytest

from eventreg_ros import load
from eventreg_ros.errors import EventregError
from eventreg_ros.robustness.axes import read
from eventreg_ros.robustness.design import design_of
from eventreg_ros.robustness.plan import Plan


def axis(text):
    (found,), fixed = read([text])
    assert fixed == []
    return found


@pytest.mark.parametrize(
    ('spec', 'values'),
    [
        ('1..3/5', [1.0, 1.5, 2.0, 2.5, 3.0]),
        ('0.01..1/3log', [0.01, 0.1, 1.0]),
        ('-1e-1..1e-1/3', [-0.1, 0.0, 0.1]),
        ('{1, 2.5,4}', [1.0, 2.5, 4.0]),
        ('{1/4,1/2}', [0.25, 0.5]),
        ('1/4..1/2/3', [0.25, 0.375, 0.5]),
        ('1/4..0.5/3', [0.25, 0.375, 0.5]),
        ('{zero,linear}', ['zero', 'linear']),
    ],
)
def test_values_of_a_grid(spec, values):
    found = axis(f'plant.k:={spec}')
    assert found.values == pytest.approx(values) if isinstance(values[0], float) else True
    assert list(found.values) == values or isinstance(values[0], float)
    assert (found.node, found.parameter, found.index) == ('plant', 'k', None)


def test_names():
    assert axis('/**.k:=1..2/2').node == '/**'
    assert axis('/r1/plant.x0[1]:=1..2/2').node == 'r1/plant'
    assert axis('plant.x0[1]:=1..2/2').index == 1
    assert axis('links.delay:=0..1/3').parameter == 'delay'


def test_one_value_is_fixed():
    assert read(['plant.k:=2', 'plant.model:=neuron', 'stimulus.file:=../a..b.csv'])[0] == []


@pytest.mark.parametrize(
    ('spec', 'law'),
    [
        ('2..6', lambda u: 2.0 + 4.0 * u),
        ('1/4..3/4', lambda u: 0.25 + 0.5 * u),
        ('1..100log', lambda u: 10.0 ** (2.0 * u)),
        ('1..100 log', lambda u: 10.0 ** (2.0 * u)),
    ],
)
def test_laws(spec, law):
    u = np.array([0.0, 0.25, 0.9])
    assert axis(f'plant.k:={spec}').at(u) == pytest.approx(law(u))


def test_mismatch_is_normal_with_that_deviation():
    drawn = axis('plant.k:=-4~10%').at(np.random.default_rng(1).random(20000))
    assert drawn.mean() == pytest.approx(-4.0, abs=0.02)
    assert drawn.std() == pytest.approx(0.4, rel=0.03)
    assert np.mean(np.abs(drawn + 4.0) < 0.4) == pytest.approx(0.6827, abs=0.015)


@pytest.mark.parametrize(
    ('texts', 'words'),
    [
        (['plant.k:=1..2/1'], 'needs 2 to 10000000 values'),
        (['plant.k:=1..2/99999999'], 'needs 2 to 10000000 values'),
        (['plant.k:=1..2/' + '9' * 5000], 'needs 2 to 10000000 values'),
        (['plant.k:=1e308..-1e308/3'], 'must be finite'),
        (['plant.k:=1~1e400%'], 'must be > 0 and finite'),
        (['plant.x0[0]:=0~10%'], 'must be > 0 and finite'),
        (['plant.k:=1~0%'], 'must be > 0 and finite'),
        (['plant.k:=1~-10%'], 'must be > 0 and finite'),
        (['plant.x0[' + '9' * 5000 + ']:=0..1/2'], 'must be NODE.PARAM:=VALUE'),
        (['plant.k:=-1..2/5log'], 'reach or cross 0'),
        (['plant.k:={}'], 'must hold values'),
        (['plant.k:=1..2/2', 'plant.k:=1..3/2'], 'varied already'),
        (['links.delai:=0..1/2'], "did you mean 'delay'"),
        (['plant:=1..2/2'], 'must be NODE.PARAM:=VALUE'),
    ],
)
def test_what_is_refused(texts, words):
    with pytest.raises(EventregError, match=words) as caught:
        read(texts)
    assert '\n' not in str(caught.value)


def test_a_grid_of_too_many_sets_is_refused():
    axes = read([f'plant.{name}:=0..1/10000' for name in ('k', 'tau')])[0]
    with pytest.raises(EventregError, match=r'at most 10000000 sets, got 1e\+08'):
        design_of(axes)


def test_a_grid_runs_through_the_last_axis_first():
    design = design_of(read(['plant.k:={1,2}', 'plant.tau:={3,4,5}'])[0])
    assert design.count == 6
    assert [column.tolist() for column in design.columns(1, 5)] == [[1, 1, 2, 2], [4, 5, 3, 4]]


@pytest.mark.slow
@pytest.mark.parametrize('sampling', ['random', 'sobol'])
def test_any_stretch_of_a_sample_is_that_of_the_whole(sampling):
    design = design_of(read(['plant.k:=0..1', 'plant.tau:=0..1'])[0], 2048, 7, sampling)
    whole = np.array(design.columns(0, 2048))
    for first, last in ((0, 1), (5, 700), (1000, 1030), (1024, 2048), (2047, 2048)):
        assert np.array_equal(np.array(design.columns(first, last)), whole[:, first:last])
    assert whole.min() >= 0.0
    assert whole.max() < 1.0
    assert whole.mean(axis=1) == pytest.approx([0.5, 0.5], abs=0.02)
    other = design_of(design.axes, 2048, 8, sampling)
    assert not np.array_equal(np.array(other.columns(0, 2048)), whole)


@pytest.mark.parametrize(
    ('spec', 'sets', 'sampling', 'words'),
    [
        ('0..1', None, 'grid', r'--sets N, or write plant.k:=A..B/N'),
        ('0..1', 100, 'sobol', 'a power of 2'),
        ('0..1', 2 * 10**7, 'random', r'at most 10000000 sets, got 2e\+07'),
    ],
)
def test_designs_that_are_refused(spec, sets, sampling, words):
    with pytest.raises(EventregError, match=words):
        design_of(read([f'plant.k:={spec}'])[0], sets, 0, sampling)


@pytest.mark.parametrize(
    ('more', 'words'),
    [
        ({'sets': 0}, 'sets must be a whole number >= 1, got 0'),
        ({'sets': 4.0}, 'sets must be a whole number >= 1, got 4.0'),
        ({'sets': True}, 'sets must be a whole number >= 1, got True'),
        ({'sets': 4, 'seed': -1}, 'seed must be a whole number >= 0, got -1'),
        ({'sets': 4, 'seed': '1'}, "seed must be a whole number >= 0, got '1'"),
        ({'sets': 4, 'duration': '9'}, "duration must be a number, of model time, got '9'"),
        ({'sets': 4, 'window': [5]}, r'window must be a number, of model time, got \[5\]'),
        ({'sets': 4, 'on': ()}, r'on must name signals \(y, u\), got \(\)'),
    ],
)
def test_what_python_asks_for_is_checked_as_on_a_command_line(more, words):
    with pytest.raises(EventregError, match=f'^{words}'):
        Plan.of(load('exact'), ['controller.k:=1..2'], **more)


def test_a_signal_may_be_called_y_in_a_list():
    (axis,) = read(['controller.output:={y,n,3}'])[0]
    assert axis.values == ('y', 'n', 3.0)
