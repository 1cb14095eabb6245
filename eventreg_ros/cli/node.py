# SPDX-License-Identifier: Apache-2.0
"""eventreg node: one node, as ``ros2 run eventreg_ros NODE`` runs it."""

from __future__ import annotations

import argparse

from ..nodes import executables
from ..scenario.names import KINDS


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument('node', metavar='NODE', choices=list(KINDS), help=', '.join(KINDS))
    parser.add_argument(
        'arguments',
        nargs=argparse.REMAINDER,
        metavar='...',
        help='--help, or --ros-args with parameters and remappings of the node',
    )


def main(args: argparse.Namespace) -> int:
    """Run the node until SIGINT or SIGTERM."""
    return executables.run(args.node, args.arguments)
