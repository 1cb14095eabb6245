# SPDX-License-Identifier: Apache-2.0
"""``eventreg live``: the running loop in Lichtblick or Foxglove, without ROS tools."""

from __future__ import annotations

import argparse

from .arguments import whole


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``live``."""
    parser.add_argument(
        '--port', type=whole(0), default=8765, metavar='N',
        help='listen on this port of the loopback (8765); 0: any',
    )  # fmt: skip


def main(args: argparse.Namespace) -> int:
    """Serve until the run ends or Ctrl-C comes, and return 0."""
    from ..session.live_view import serve

    try:
        serve(args.port, lambda line: print(line, flush=True))
    except KeyboardInterrupt:
        return 0
    print('the run has ended')
    return 0
