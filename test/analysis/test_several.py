# SPDX-License-Identifier: Apache-2.0
"""Several plants, several exosystems: each plant judged by its own, and the sums, end to end."""

import json

import numpy as np
import pytest

from eventreg_ros import simulate
from eventreg_ros.analysis.events import detect
from eventreg_ros.analysis.report_json import as_json
from eventreg_ros.analysis.report_table import table
from eventreg_ros.analysis.signal import Signal, Size, difference, ordered, size, together, total
from eventreg_ros.cli.main import main
from eventreg_ros.scenario import parse

EXACT = 'tau: 0.08333333333333333, k: 2.0'
TWO_PLANTS = f"""\
exosystem: {{ros__parameters: {{{EXACT}}}}}
exosystem_2: {{ros__parameters: {{tau: 0.052}}}}
plant_left: {{ros__parameters: {{excitatory: [w, v], inhibitory: [u]}}}}
controller: {{ros__parameters: {{{EXACT}, excitatory: [y_left], inhibitory: [y_r_left]}}}}
reference_left: {{ros__parameters: {{}}}}
plant_right: {{ros__parameters: {{excitatory: [w, w_2], inhibitory: []}}}}
stimulus: {{ros__parameters: {{waveform: pulses, amplitude: 1.5, onsets: [110, 190, 250, 290]}}}}
"""
BANK = """\
exosystem: {ros__parameters: {tau: 0.08333333333333333}}
exosystem_2: {ros__parameters: {tau: 0.05263157894736842, x0: [-0.4, 0.6, 0.9, -0.3]}}
plant: {ros__parameters: {excitatory: [w, w_2], inhibitory: [u, u_2]}}
controller: {ros__parameters: {tau: 0.08333333333333333}}
controller_2: {ros__parameters: {tau: 0.05263157894736842}}
spike_monitor: {ros__parameters: {settle: 600.0}}
"""


@pytest.fixture(scope='module')
def two_plants():
    return simulate(parse(TWO_PLANTS, 'two'), 400.0, sampled=True)


def after(run, name):
    return [t for t in detect(run.t, run[name]) if t >= 100.0]


def test_each_plant_is_judged_by_its_own(two_plants):
    report, run = two_plants.report, two_plants
    left, right = report.plants
    assert (left.plant.output, left.plant.reference) == ('y_left', 'y_r_left')
    assert left.verdict == 'rejected'
    assert left.rejection.disturbance_events == len(after(run, 'w'))
    assert left.rejection.preserved == len(after(run, 'y_r_left')) == len(after(run, 'y_left')) > 0
    assert (right.plant.disturbances, right.plant.reference) == (('w', 'w_2'), None)
    assert right.rejection.disturbance_events == len(after(run, 'w')) + len(after(run, 'w_2'))
    assert right.rejection.spurious == len(after(run, 'y_right')) > 0
    assert right.verdict == 'not rejected'


def test_above_them_stand_the_sums_and_the_worst(two_plants):
    report = two_plants.report
    left, right = report.plants
    for name in ('disturbance_events', 'reference_events', 'preserved', 'spurious', 'missed'):
        total_of = getattr(left.rejection, name) + getattr(right.rejection, name)
        assert getattr(report.rejection, name) == total_of
    spurious, events = report.rejection.spurious, report.rejection.disturbance_events
    assert report.rejection.ratio == 1.0 - spurious / events
    assert report.verdict == 'not rejected'
    assert report.reason == f'y_right: {right.reason}'
    assert report.residual.max_abs == max(left.residual.max_abs, right.residual.max_abs)
    assert report.residual.rms == pytest.approx(
        np.hypot(left.residual.rms, right.residual.rms) / np.sqrt(2)
    )
    assert right.synchronisation == Size(None, None)  # it has no controller
    assert report.synchronisation == left.synchronisation


def test_the_json_has_plants_only_where_there_are_several(two_plants):
    found = as_json(two_plants.report)
    assert list(found['plants']) == ['y_left', 'y_right']
    for entry in found['plants'].values():
        assert list(entry) == ['verdict', 'rejection', 'residual']
    assert list(found['signals']) == ['w', 'w_2', 'v', 'y_left', 'y_right', 'y_r_left', 'u']
    assert 'plants' not in as_json(simulate('exact', 110.0).report)


def test_the_table_has_a_line_for_each(two_plants):
    text = table(two_plants.report)
    assert '\ny_left: disturbance ' in text
    assert '\ny_right: disturbance ' in text
    assert '\nresidual y_left - y_r_left: max ' in text
    assert '\nsynchronisation w - u: max ' in text


@pytest.mark.parametrize(
    ('without', 'verdict'),
    [('plant_right', 'rejected'), ('exosystem', 'not rejected'), ('controller', 'not rejected')],
)
def test_what_is_missing_changes_the_verdict(without, verdict):
    lines = [line for line in TWO_PLANTS.splitlines() if not line.startswith(f'{without}:')]
    assert simulate(parse('\n'.join(lines), 'two'), 400.0, sampled=True).verdict == verdict


def test_undecided_is_worse_than_rejected_and_better_than_not_rejected(two_plants):
    text = TWO_PLANTS.replace('[w, w_2], inhibitory: []', '[], inhibitory: []')
    report = simulate(parse(text, 'two'), 400.0, sampled=True).report
    assert [plant.verdict for plant in report.plants] == ['rejected', 'undecided']
    assert report.verdict == 'undecided'
    assert report.reason == 'y_right: nothing disturbs y_right: there is no w; add an exosystem'


@pytest.mark.slow
def test_events_of_several_generators_count_together_and_their_sums_are_compared():
    run = simulate(parse(BANK, 'bank'), 900.0, sampled=True)
    report = run.report
    counts = [sum(t >= 600.0 for t in detect(run.t, run[name])) for name in ('w', 'w_2')]
    assert report.rejection.disturbance_events == sum(counts)
    assert all(counts)
    assert (report.verdict, report.settle, report.rejection.spurious) == ('rejected', 600.0, 0)
    late = run.t >= 600.0
    left = (run['w'] + run['w_2'] - run['u'] - run['u_2'])[late]
    assert report.synchronisation.max_abs == pytest.approx(np.abs(left).max(), rel=1e-12)
    assert report.residual.max_abs == np.abs(run['y'][late]).max()


@pytest.mark.slow
def test_the_command_lasts_until_a_late_settler_is_judged(tmp_path, capsys):
    (tmp_path / 'bank.yaml').write_text(BANK)
    out = tmp_path / 'bank.json'
    words = ['simulate', str(tmp_path / 'bank.yaml'), '--sampled', '--json', str(out)]
    assert main(words) == 0
    found = json.loads(out.read_text())
    assert (found['duration'], found['settle']) == (900.0, 600.0)
    assert capsys.readouterr().out.splitlines()[-1] == 'verdict: rejected'
    assert main([*words, '--settle', '400']) == 0
    assert json.loads(out.read_text())['duration'] == 700.0


# Sums and sizes -----------------------------------------------------------------------------------


def test_a_sum_is_known_where_all_its_parts_are():
    t = np.arange(5.0)
    signals = {'a': Signal(t, t), 'b': Signal(t[1:4], 10.0 * t[1:4])}
    found = total(signals, ('a', 'b'))
    assert (found.t.tolist(), found.x.tolist()) == ([1.0, 2.0, 3.0], [11.0, 22.0, 33.0])
    assert len(total(signals, ('a', 'c')).t) == len(total(signals, ()).t) == 0
    left = difference(Signal(t, t), total(signals, ('b',)))
    assert left.x.tolist() == [-9.0, -18.0, -27.0]


def test_sizes_together():
    assert together([Size(3.0, 3.0), Size(4.0, 4.0)]) == Size(4.0, pytest.approx(np.sqrt(12.5)))
    assert together([Size(1.0, 0.5), Size(None, None)]) == Size(1.0, 0.5)
    assert together([Size(None, None)]) == together([]) == Size(None, None)
    assert together([Size(1e300, 1e300)] * 2) == Size(1e300, 1e300)
    t = np.arange(11.0)
    assert size(Signal(t, np.where(t > 5.0, 9.0, -2.0)), (0.0, 5.0)) == Size(2.0, 2.0)


def test_a_name_with_a_suffix_comes_after_the_one_without():
    names = ['zeta', 'u_b', 'y_r', 'alpha', 'y', 'w_2', 'v', 'w', 'y_left', 'y_r_left', 'u']
    assert ordered(names) == [
        'w', 'w_2', 'v', 'y', 'y_left', 'y_r', 'y_r_left', 'u', 'u_b', 'alpha', 'zeta',
    ]  # fmt: skip
