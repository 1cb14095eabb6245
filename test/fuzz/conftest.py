# SPDX-License-Identifier: Apache-2.0
"""What the generated tests share: how many cases, from which seed, and the limits for each case.

``make test`` tries some 700 cases, always the same ones. ``make fuzz`` tries 20 times as many, and
``make fuzz SEED=7`` others. EVENTREG_FUZZ is the factor, EVENTREG_FUZZ_SEED the seed, and with
EVENTREG_FUZZ_CASE a failure's number is tried alone.
"""

import os
import random
import signal
import time
import warnings
from collections import Counter
from contextlib import contextmanager
from pathlib import Path

import pytest

from eventreg_ros.cli.main import main
from eventreg_ros.errors import LONGEST

os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'

FACTOR = float(os.environ.get('EVENTREG_FUZZ', '1'))
SEED = os.environ.get('EVENTREG_FUZZ_SEED', '1')
CASE = os.environ.get('EVENTREG_FUZZ_CASE')

SECONDS, MIB = 10.0, 500
"""CPU time and memory that a case may take."""

SPECIAL = '\x00\n\t "\'#%&*+,-./:;<=>?@[]_`{|}~\\\u202e\u0663\udc80é😀'


class TookTooLongError(BaseException):
    """A case that nothing of ours may catch."""


@pytest.fixture
def fuzz(request):
    """Try a case ``few`` times in ``make test``, each with a generator of its own.

    All are tried; the failures are reported together, and, with -s, how often a case returned what.
    """

    def run(few, case):
        failures, results, name = [], Counter(), request.node.name
        for i in [int(CASE)] if CASE else range(int(few * FACTOR)):
            try:
                results[case(random.Random(f'{SEED} {name} {i}'))] += 1
            except Exception as error:
                failures.append(f'{i}: {type(error).__name__}: {str(error).splitlines()[0]}')
        print(f'\n{name}: {dict(results)}, {len(failures)} failed')
        assert not failures, f'{len(failures)} failed, the first:\n' + '\n'.join(failures[:20])

    return run


@pytest.fixture
def domain():
    """A ROS domain that nobody else has, on the loopback."""
    from eventreg_ros.session.domain import loopback_domain

    with loopback_domain({}) as found:
        yield int(found['ROS_DOMAIN_ID'])


@contextmanager
def limited():
    """Fail when the block takes more CPU time or memory than a case may."""

    def stop(number, frame):
        raise TookTooLongError(f'more than {SECONDS:g} s of CPU')

    before, handler = _memory(peak=False), signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, SECONDS)
    began = time.process_time()
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, handler)
    assert time.process_time() - began <= SECONDS
    assert _memory(peak=True) - before <= MIB


def _memory(peak):
    """MiB that the process holds, or held at most since it was last asked what it holds."""
    if not Path('/proc/self/clear_refs').exists():  # only Linux tells
        return 0.0
    if not peak:
        Path('/proc/self/clear_refs').write_text('5')
    status = Path('/proc/self/status').read_text()
    key = 'VmHWM' if peak else 'VmRSS'
    return next(int(line.split()[1]) for line in status.splitlines() if key in line) / 1024


@pytest.fixture(name='limited')
def _limited():
    return limited


@pytest.fixture
def answered(capsys):
    """Run the command within the limits; return its exit code and its lines on standard error.

    It ends with a verdict, or with 2 and one line; never with a traceback or a fault of its own,
    nor do warnings of Python's get through.
    """

    def run(arguments):
        try:
            with limited(), warnings.catch_warnings(record=True) as warned:
                warnings.simplefilter('always')
                warnings.simplefilter('ignore', ResourceWarning)
                code = main(arguments)
        except SystemExit as end:  # argparse's
            code = end.code or 'sys.exit(0)'
        except BaseException as error:
            raise AssertionError(f'{arguments}: {error!r}') from error
        assert not warned, (arguments, [str(each.message) for each in warned])
        lines = capsys.readouterr().err.splitlines()
        assert code in (0, 1, 2, 3), (arguments, code, lines)
        bad = [line for line in lines if not _is_fine(line)]
        assert not bad, (arguments, bad)
        if code == 2:
            errors = [line for line in lines if 'numba is not installed' not in line]
            assert len(errors) == 1, (arguments, lines)
        return code, lines

    return run


def _is_fine(line):
    return line.startswith('eventreg: ') and len(line) <= LONGEST and line.isprintable()


def mangled(text, draw):
    """Return a text with one to three characters put in, taken out, changed or repeated."""
    for _ in range(draw.randint(1, 3)):
        at = draw.randint(0, len(text))
        match draw.randrange(5):
            case 0:
                text = text[:at] + draw.choice(SPECIAL) + text[at:]
            case 1:
                text = text[:at] + text[at + 1 :]
            case 2:
                text = text[:at] + draw.choice(SPECIAL) + text[at + 1 :]
            case 3:
                more = text[at : at + draw.randint(1, 9)] * draw.choice([1, 50])
                text = text[:at] + more + text[at:]
            case _:
                text = text[:at]
    return text


@pytest.fixture(name='mangled')
def _mangled():
    return mangled
