"""The command ``eventreg``: finds the verb, runs it, turns errors into one line and exit code 2."""

from __future__ import annotations

import argparse
import importlib
import os
import sys
from collections.abc import Sequence
from typing import NoReturn

from ..errors import EventregError

VERBS = {
    'run': 'start the nodes of a scenario, record a bag, analyse it, print the verdict',
    'node': 'run one node, as ros2 run eventreg_ros NODE does',
    'simulate': 'the scenario offline, as one continuous system or sample by sample',
    'analyze': 'events, rejection, residual and timing of a recorded bag',
    'compare': 'several bags or scenarios side by side: events that differ, distances',
    'certify': 'what theory says: contraction, antiphase, internal model, Hurwitz, exponents',
    'margin': 'the largest delay, loss and jitter that the loop bears',
    'figures': "the paper's figures, and those that it argues in words",
}
"""Each verb is a module beside this one; it has ``add_arguments(parser)`` and ``main(args)``."""


class Parser(argparse.ArgumentParser):
    """An argument parser whose errors are one line."""

    def error(self, message: str) -> NoReturn:
        """Print one line and exit with 2."""
        sys.exit(fail(f'{message}; see {self.prog} --help'))


def fail(message: object) -> int:
    """Print ``message`` as one line on standard error and return the exit code of bad input."""
    print('eventreg: ' + ' '.join(str(message).split()), file=sys.stderr)
    return 2


def build_parser(verb: str | None) -> Parser:
    """Return the parser with the arguments of ``verb``; the other verbs are only named."""
    parser = Parser(prog='eventreg', description='Event disturbance rejection, run and judged.')
    verbs = parser.add_subparsers(dest='verb', metavar='COMMAND', required=True)
    for name, summary in VERBS.items():
        sub = verbs.add_parser(name, help=summary, description=summary, allow_abbrev=False)
        if name == verb:
            module(name).add_arguments(sub)
    return parser


def module(verb: str):  # type: ignore[no-untyped-def]
    """Import the module of ``verb``: only its own imports are paid for."""
    return importlib.import_module(f'.{verb}', __package__)


def main(argv: Sequence[str] | None = None) -> int:
    """Run ``eventreg`` with ``argv`` (default: the process's) and return the exit code."""
    argv = list(sys.argv[1:] if argv is None else argv)
    verb = next((word for word in argv if not word.startswith('-')), None)
    args = build_parser(verb).parse_args(argv)
    try:
        code = int(module(args.verb).main(args))
        sys.stdout.flush()
        return code
    except EventregError as error:
        return fail(error)
    except KeyboardInterrupt:
        return 130
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 141
    except OSError as error:
        return fail(error)
