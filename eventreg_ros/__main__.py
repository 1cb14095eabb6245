# SPDX-License-Identifier: Apache-2.0
# PYTHON_ARGCOMPLETE_OK
"""``eventreg``, and ``python -m eventreg_ros``: the command as a process."""

from __future__ import annotations

import os
import signal
import sys

from . import interrupts

COMPUTING = ('margin', 'simulate', 'sweep')
"""Verbs that are there to compute, with threads of their own."""


def use_one_thread() -> None:
    """Leave it to one thread what numpy does in several: the others would wait in a busy loop."""
    os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')


def main() -> int:
    """Run the command and return its exit code; it may be interrupted from the first import on."""
    code = 0 if sys.argv[1:2] == ['node'] else interrupts.INTERRUPTED
    interrupts.handle(lambda *_: os._exit(code))  # there is nothing to clean up yet
    interrupts.unblock()
    if '_ARGCOMPLETE' in os.environ:
        from .cli.completion import offer

        offer()
    from .cli.main import main as command

    if sys.argv[1:2] and sys.argv[1] in COMPUTING:
        use_one_thread()
    try:
        code = command()
    finally:
        interrupts.handle(signal.SIG_IGN)  # the work is done; Python's own end takes its time
    if code == interrupts.INTERRUPTED:
        # Python itself may end by SIGINT after a KeyboardInterrupt, though it was caught.
        os._exit(code)
    return code


if __name__ == '__main__':
    sys.exit(main())
