# SPDX-License-Identifier: Apache-2.0
"""The command ``eventreg``: finds the verb, runs it, turns errors into one line and exit code 2."""

from __future__ import annotations

import argparse
import importlib
import sys
from collections.abc import Sequence
from typing import NoReturn

from .. import __version__
from .epilogs import EPILOGS
from .process import fail, guarded
from .standard_output import divided

VERBS = {
    'run': 'start the nodes of a scenario, record a bag, analyse it, print the verdict',
    'simulate': 'simulate the scenario offline, as one continuous system or sample by sample',
    'analyze': 'judge a recorded bag: events, rejection, residual, timing, evidence',
    'compare': 'set several bags or scenarios side by side: events that differ, distances',
    'identify': 'find the time constant of the generator behind a recorded spike train',
    'certify': 'list what theory says: contraction, antiphase, internal model, Hurwitz, exponents',
    'margin': 'find the largest delay, loss and jitter that the loop tolerates',
    'sweep': 'run the sampled loop over many sets of parameters: table, border, yield, worst set',
    'figures': "draw the paper's figures, and those that it argues in words",
    'list': 'list the shipped scenarios, a line each',
    'new': 'write a commented scenario file to begin with',
    'set': 'set a parameter of the running loop',
    'activate': 'switch on a node of the running loop',
    'deactivate': 'switch off a node of the running loop',
    'live': 'show the running loop in Lichtblick or Foxglove',
    'node': 'run one node, as ros2 run eventreg_ros NODE does',
}
"""Each verb is a module beside this one; it has ``add_arguments(parser)`` and ``main(args)``."""


class Parser(argparse.ArgumentParser):
    """An argument parser whose errors are one line."""

    def error(self, message: str) -> NoReturn:
        """Print one line and exit with 2."""
        sys.exit(fail(f'{message}; see {self.prog} --help'))


def build_parser(verb: str | None) -> Parser:
    """Return the parser with the arguments of ``verb``; the other verbs are only named."""
    parser = Parser(
        prog='eventreg',
        description='Event disturbance rejection, run and judged.',
        epilog='eventreg COMMAND --help says more, with examples; eventreg list names scenarios.',
    )
    parser.add_argument('--version', action='version', version=f'eventreg_ros {__version__}')
    verbs = parser.add_subparsers(dest='verb', metavar='COMMAND', required=True)
    for name, summary in VERBS.items():
        sub = verbs.add_parser(
            name,
            help=summary,
            description=f'{summary[0].upper()}{summary[1:]}.',
            epilog=EPILOGS.get(name),
            formatter_class=argparse.RawDescriptionHelpFormatter,
            allow_abbrev=False,
        )
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
    if not argv:
        build_parser(None).print_help()
        return 2

    def work() -> int:
        if verb is not None and verb not in VERBS:
            from ..scenario.hint import hint

            return fail(f'no command {verb!r}{hint(verb, VERBS)}')
        args, unknown = build_parser(verb).parse_known_args(argv)
        if unknown:
            listed = all(':=' in word for word in unknown)  # a shell makes words of {1,2}
            quotes = "put a list in quotes, 'NODE.PARAM:={1,2}'; " if listed else ''
            return fail(
                f'unrecognized arguments: {" ".join(unknown)}; '
                f'{quotes}see eventreg {args.verb} --help'
            )
        try:
            with divided(args):
                return int(module(args.verb).main(args))
        except SystemExit as error:  # of another package: no verdict of ours
            raise RuntimeError(f'something called sys.exit({error.code!r})') from error

    return guarded(work, interruptible=verb != 'node')
