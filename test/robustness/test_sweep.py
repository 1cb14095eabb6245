# SPDX-License-Identifier: Apache-2.0
"""Sweeps that are kept: stopped and gone on with, refused, read again."""

import json
import signal
from threading import Event

import numpy as np
import pytest

from eventreg_ros import load, sweep
from eventreg_ros.errors import EventregError
from eventreg_ros.robustness import sweep as module
from eventreg_ros.robustness.plan import Plan
from eventreg_ros.robustness.store import Store
from eventreg_ros.robustness.sweep import run_here, run_sweep

PARAMETERS = ('controller.k:=-0.1..2/40', 'controller.tau:={0.05,0.09}', '/**.rate:=50')


@pytest.fixture(autouse=True)
def _pieces(monkeypatch):
    monkeypatch.setattr(module, 'FIRST', 7)
    monkeypatch.setattr(module, 'MOST', 7)


def plan(*parameters, **more):
    quick = {'duration': 250.0, 'settle': 60.0, **more}
    return Plan.of(load('exact'), parameters or PARAMETERS, **quick)


def stop_after(pieces):
    """Run ``pieces`` pieces, then be interrupted."""

    def run(plan, stretches):
        for i, done in enumerate(run_here(plan, stretches)):
            if i == pieces:
                raise KeyboardInterrupt
            yield done

    return run


@pytest.mark.slow
@pytest.mark.parametrize('suffix', ['.csv', ''])
def test_interrupted_sweeps_end_in_the_same_bytes(tmp_path, suffix):
    if not suffix:
        pytest.importorskip('pyarrow')
    whole = run_sweep(plan(), tmp_path / f'whole{suffix}')
    assert (whole.sets, whole.bad) == (80, 4)
    assert whole.rejected
    assert whole.not_rejected
    pieces = tmp_path / f'pieces{suffix}'
    for count in (1, 0, 3, 2):
        with pytest.raises(KeyboardInterrupt):
            run_sweep(plan(), pieces, stop_after(count))
        assert not list(pieces.glob('sweep.[cp]*'))
    done = []
    run_sweep(plan(), pieces, progress=lambda *counts: done.append(counts))
    assert done[0] == (42, 80)
    assert done[-1] == (80, 80)
    name = f'sweep{suffix or ".parquet"}'
    assert (pieces / name).read_bytes() == (tmp_path / f'whole{suffix}' / name).read_bytes()
    assert not (pieces / 'parts').exists()


@pytest.mark.slow
def test_a_killed_command_goes_on(tmp_path, spawn, eventreg):
    command = [
        'sweep',
        'exact',
        '-p',
        'controller.k:=0.5..4/120',
        '-p',
        'controller.tau:=0.05..0.1/120',
    ]
    command += ['-p', '/**.rate:=50', '--duration', '200', '--out']
    process = spawn('-m', 'eventreg_ros', *command, tmp_path / 'killed.csv')
    while not list((tmp_path / 'killed.csv' / 'parts').glob('*.npz')) and process.poll() is None:
        pass
    process.send_signal(signal.SIGKILL)
    process.wait()
    assert eventreg(*command, tmp_path / 'killed.csv').returncode == 0
    assert eventreg(*command, tmp_path / 'whole.csv').returncode == 0
    tables = [(tmp_path / name / 'sweep.csv').read_bytes() for name in ('killed.csv', 'whole.csv')]
    assert tables[0] == tables[1]
    assert tables[0].count(b'\n') == 120 * 120 + 1


def test_another_sweep_in_the_same_place_is_refused(tmp_path):
    out = tmp_path / 'a.csv'
    run_sweep(plan(), out)
    for other in (
        plan('controller.k:=-0.1..2/41', *PARAMETERS[1:]),
        plan(settle=61.0),
        plan(*PARAMETERS, 'plant.k:=1.5'),
    ):
        with pytest.raises(EventregError, match='holds another sweep: its ') as caught:
            run_sweep(other, out)
        assert len(str(caught.value)) <= 300 + len(str(out))
    (tmp_path / 'b').mkdir()
    (tmp_path / 'b' / 'precious').touch()
    with pytest.raises(EventregError, match='holds no sweep'):
        run_sweep(plan(), tmp_path / 'b')


def test_a_finished_sweep_is_read_not_run(tmp_path):
    out = tmp_path / 'a.csv'
    first = run_sweep(plan(), out)

    def never(plan, stretches):
        raise AssertionError('run again')

    again = run_sweep(plan(), out, never)
    assert again.as_json() == first.as_json()
    for name, column in first.columns.items():
        assert again[name].tolist() == column.tolist() or column.dtype.kind == 'f'
    assert json.loads((out / 'sweep.json').read_text())['plan']['parameters'] == list(PARAMETERS)
    assert (out / 'scenario.yaml').read_text() == load('exact').to_yaml()


def test_rows_without_a_verdict_say_why(tmp_path):
    found = run_sweep(plan())
    bad = [i for i, word in enumerate(found['verdict']) if word is None]
    assert bad == [0, 1, 2, 3]
    assert found['reason'][0] == 'controller.k must be a finite number >= 0, got -0.1'
    assert [word for word in found['reason'][4:] if word is not None] == []
    assert found['controller.k'][:2].tolist() == [-0.1, -0.1]


def test_the_table_is_typed(tmp_path):
    parquet = pytest.importorskip('pyarrow.parquet')
    run_sweep(plan(), tmp_path / 'a')
    table = parquet.read_table(tmp_path / 'a' / 'sweep.parquet')
    names = ['controller.k', 'controller.tau', 'verdict', 'disturbance_events', 'preserved',
             'spurious', 'missed', 'residual_max_abs', 'residual_rms']  # fmt: skip
    assert table.column_names[: len(names)] == names
    assert table['spurious'].null_count == table['residual_rms'].null_count == 4
    assert str(table['spurious'].type) == 'int32'
    assert table['verdict'].null_count == 4


@pytest.mark.slow
def test_the_library_gives_the_same_table():
    more = {'duration': 250.0, 'settle': 60.0}
    parameters = {'controller.k': [0.7, 2], 'controller.tau': '0.05..0.1/3', '/**.rate': 50.0}
    found = sweep('exact', parameters, **more)
    command = ('controller.k:={0.7,2}', 'controller.tau:=0.05..0.1/3', '/**.rate:=50.0')
    same = run_sweep(plan(*command))
    assert found.as_json() | {'seconds': 0} == same.as_json() | {'seconds': 0}
    for name, column in same.columns.items():
        assert found[name].tolist() == column.tolist()
    assert repr(found).startswith('<Sweep of exact: 6 sets, ')
    assert len(found.plot().axes) >= 2
    frame = pytest.importorskip('pandas') and found.to_dataframe()
    assert len(frame) == 6
    assert sweep('exact', {'plant.k': '1~5%'}, sets=3, seed=2, **more)['plant.k'].std() > 0


@pytest.mark.parametrize(
    ('parameters', 'more', 'words'),
    [
        ({'controller.q': [1, 2]}, {}, "controller has no parameter 'q'"),
        ({'controller.kk': '1..2/2'}, {}, "did you mean 'k'"),
        ({'/**.kk': [1]}, {}, "has no parameter 'kk'"),
        ({'controller.k': '1..2'}, {'sets': 0}, 'sets must be a whole number >= 1, got 0'),
        ({'controller.k': '1..2'}, {'sets': 3, 'sampling': 'dice'}, 'one of random, sobol'),
    ],
)
def test_what_no_set_could_have_is_refused_at_once(parameters, more, words):
    with pytest.raises(EventregError, match=words):
        sweep('exact', parameters, **more)


@pytest.fixture
def begun(tmp_path):
    """A sweep that was interrupted, of which parts are there."""
    with pytest.raises(KeyboardInterrupt):
        run_sweep(plan(), tmp_path / 'a.csv', stop_after(3))
    return tmp_path / 'a.csv'


def cut(path):
    path.write_bytes(path.read_bytes()[:200])


@pytest.mark.parametrize(
    'damage',
    [
        lambda part: cut(part),
        lambda part: part.write_bytes(b''),
        lambda part: part.write_bytes(part.read_bytes().replace(b'rows', b'rosw')),
        lambda part: part.rename(part.with_name('000000000007-000000000009.npz')),
        lambda part: part.rename(part.with_name('000000000700-000000000707.npz')),
    ],
)
def test_a_part_that_was_damaged_is_run_again(begun, damage):
    damage(sorted((begun / 'parts').iterdir())[1])
    (begun / '.eventreg_99999999_1.csv').touch()  # of a process that was killed as it wrote
    found = run_sweep(plan(), begun)
    assert found.sets == 80
    whole = run_sweep(plan())
    assert np.array_equal(found['residual_rms'], whole['residual_rms'], equal_nan=True)
    assert sorted(path.name for path in begun.iterdir()) == [
        'scenario.yaml', 'sweep.csv', 'sweep.json'
    ]  # fmt: skip


def test_a_table_that_was_damaged_is_made_again(tmp_path):
    out = tmp_path / 'a.csv'
    run_sweep(plan(), out)
    before = (out / 'sweep.csv').read_bytes()
    cut(out / 'sweep.csv')
    run_sweep(plan(), out)
    assert (out / 'sweep.csv').read_bytes() == before
    (out / 'sweep.csv').write_bytes(bytes([255]) * len(before))
    with pytest.raises(EventregError, match=r'cannot read .*sweep\.csv: .* run the sweep again'):
        run_sweep(plan(), out)['verdict']


@pytest.mark.parametrize('text', ['', '{"plan', '[]', '{"plan": null}', '{"plan": "exact"}'])
def test_what_does_not_say_what_the_sweep_was_is_refused(begun, text):
    (begun / 'sweep.json').write_text(text)
    with pytest.raises(EventregError, match='does not say what the sweep was; remove'):
        run_sweep(plan(), begun)


def test_two_at_once_in_one_place_are_refused(begun):
    pytest.importorskip('fcntl')

    def run(a_plan, stretches):
        with pytest.raises(EventregError, match='another process works on the sweep in'):
            run_sweep(plan(), begun)
        return run_here(a_plan, stretches)

    assert run_sweep(plan(), begun, run).sets == 80


def test_of_two_sweeps_that_begin_in_one_place_the_second_is_refused(tmp_path):
    """Both found nothing there; what is written is written by the one that has the lock."""
    one, other = (Store(tmp_path / 'out', each) for each in (plan(), plan(settle=20.0)))
    with one.alone():
        pass
    with pytest.raises(EventregError, match='holds another sweep: its settle was'), other.alone():
        pass


def test_what_is_raised_does_not_wait_for_what_runs():
    going, end = Event(), Event()

    def work():
        going.set()
        end.wait()

    waiting = []

    def interrupted():
        with module.pool_here() as pool:
            waiting.extend(pool.submit(work) for _ in range(100))
            going.wait()
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert waiting[-1].cancelled()
    end.set()


def test_the_seconds_of_all_runs_count(begun):
    found = run_sweep(plan(), begun, lambda plan, stretches: run_here(plan, stretches))
    assert found.seconds > 0.0
    assert run_sweep(plan(), begun).seconds == found.seconds
