# SPDX-License-Identifier: Apache-2.0
"""Progress of what takes long: a line that is written over, or lines now and then in a file."""

import io

import pytest

from eventreg_ros.cli import progress
from eventreg_ros.cli.main import main
from eventreg_ros.cli.progress import Count, Terminal


@pytest.fixture
def clock(monkeypatch):
    """Seconds that pass only where a test says so."""
    seconds = [0.0]
    monkeypatch.setattr(progress.time, 'monotonic', lambda: seconds[0])
    return seconds


def test_off_a_terminal_a_line_comes_every_ten_seconds_and_says_how_long(clock, capsys):
    count = Count('searches')
    for done in range(13):
        clock[0] = 4.0 * done
        count.show(done, 100, f'delay {done}')
    count.clear()
    assert capsys.readouterr().err.splitlines() == [
        '3 of 100 searches, 6 min to go (delay 3)',
        '6 of 100 searches, 6 min to go (delay 6)',
        '9 of 100 searches, 6 min to go (delay 9)',
        '12 of 100 searches, 6 min to go (delay 12)',
    ]


def test_what_was_done_before_does_not_make_it_look_fast(clock, capsys):
    count = Count()
    count.show(90, 100)
    clock[0] = 20.0
    count.show(92, 100)
    assert capsys.readouterr().err == '92 of 100 sets, 80 s to go\n'


def test_the_pace_is_that_of_late(clock, capsys):
    """Where the first step compiles for 100 s, the next ones say how long the rest takes."""
    count = Count(slow=1)
    for now, done in ((0.0, 0), (100.0, 1), (110.0, 11), (120.0, 21), (260.0, 161)):
        clock[0] = now
        count.show(done, 1000)
    assert capsys.readouterr().err.splitlines() == [
        '1 of 1000 sets', '11 of 1000 sets, 16 min to go',
        '21 of 1000 sets, 16 min to go', '161 of 1000 sets, 14 min to go',
    ]  # fmt: skip


def test_of_an_unknown_count_no_end_is_predicted(clock, capsys):
    count = Count()
    clock[0] = 20.0
    count.show(7, 0)
    assert capsys.readouterr().err == '7 sets\n'


def test_on_a_terminal_one_line_is_written_over(clock, capsys, monkeypatch):
    monkeypatch.setattr('sys.stderr.isatty', lambda: True)
    count = Count('figures')
    count.show(0, 4, 'exact')
    clock[0] = 10.0
    count.show(1, 4, 'open')
    count.clear()
    assert capsys.readouterr().err.split('\r\x1b[K') == [
        '', '0 of 4 figures (exact)', '1 of 4 figures, 30 s to go (open)', '',
    ]  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize(
    ('words', 'unit'),
    [
        (['margin', 'uncontrolled', '--duration', '210', '--seeds', '1'], 'of 10 searches'),
        (['figures', 'exact', 'mismatch', '--format', 'svg', '--out', '.'], 'of 2 figures'),
    ],
)
def test_margin_and_figures_show_theirs_in_a_log(words, unit, capsys, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    seconds = iter(range(0, 1000000, 30))
    monkeypatch.setattr(progress.time, 'monotonic', lambda: next(seconds))
    assert main(words) == 0
    lines = capsys.readouterr().err.splitlines()
    assert lines
    assert all(unit in line for line in lines)
    assert 'to go' in lines[-1]


def test_certify_shows_each_certificate_when_it_is_known(capsys, monkeypatch):
    from eventreg_ros.theory import certify

    def stopped(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(certify, '_exponent', stopped)
    assert main(['certify', 'exact']) == 130
    assert 'internal model' in capsys.readouterr().out


@pytest.mark.parametrize(
    'words',
    [
        ['margin', 'uncontrolled', '--duration', '210', '--seeds', '1'],
        ['sweep', 'uncontrolled', '-p', 'plant.k:={1,2}', '--duration', '20'],
    ],
)
def test_what_numba_would_save_is_said_where_it_is_missing(words, capsys, monkeypatch):
    from eventreg_ros.simulation import jit

    monkeypatch.setattr(jit, 'compiles', lambda: False)
    assert main(words) == 0
    assert 'numba is not installed, so' in capsys.readouterr().err


@pytest.mark.parametrize(
    ('terminal', 'shown'),
    [
        (False, 'first\neventreg: early\n   1.0 of 9 s   events: w 1\neventreg: late\n'),
        (True, 'first\neventreg: early\n\r   1.0 of 9 s   events: w 1\neventreg: late\n'),
    ],
)
def test_warnings_of_a_run_begin_a_line_and_leave_none_empty(terminal, shown, monkeypatch):
    both = io.StringIO()
    both.isatty = lambda: terminal
    monkeypatch.setattr('sys.stdout', both)
    monkeypatch.setattr('sys.stderr', both)
    observer = Terminal(9.0)
    observer.began('first')
    observer.warned('early')
    observer.progressed(1.0, {'w': 1})
    observer.warned('late')
    assert both.getvalue() == shown
