# SPDX-License-Identifier: Apache-2.0
"""``eventreg new FILE``: a commented scenario file to begin with."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..errors import EventregError
from ..files import need_new
from ..scenario.files import find, text_of
from .arguments import write_text

HEAD = """\
# A scenario: an ordinary ROS parameter file. It starts exactly the nodes that it names.
# Times are in model time, the time of the paper, unless a comment says seconds.
#
#   eventreg simulate {file}       the loop offline; needs no ROS
#   eventreg run {file}            the loop as ROS nodes, recorded and judged
#
# Delete a node to leave it out; add one by its name: reference, stimulus, exosystem_2, ...
# The parameters of a node: eventreg node NODE --help
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``new``."""
    parser.add_argument('file', metavar='FILE', type=Path, help='the file to write: mine.yaml')
    parser.add_argument(
        '--from', dest='source', default='mismatch', metavar='SCENARIO',
        help='the scenario to begin with, a shipped one or a file (mismatch)',
    )  # fmt: skip


def main(args: argparse.Namespace) -> int:
    """Write the file and return 0."""
    file: Path = args.file
    if file.suffix not in ('.yaml', '.yml'):
        raise EventregError(
            f'{file} must end in .yaml, so that commands recognise it as a scenario'
        )
    need_new(file)
    text = text_of(find(args.source))
    write_text(file, HEAD.format(file=file) + '#\n' + text)
    print(f'wrote {file}, from {args.source}; now: eventreg simulate {file}')
    return 0
