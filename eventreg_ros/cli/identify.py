# SPDX-License-Identifier: Apache-2.0
"""``eventreg identify``: the generator behind a recorded spike train, as a table, JSON, a scenario.

Needs no ROS. The exit code is 0 when it was identified, and 2, with one line that says why, when it
cannot be.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from ..files import need_new, need_writable
from .arguments import (
    add_json,
    add_overrides,
    add_reading,
    nonnegative,
    positive,
    warn,
    whole,
    write_json,
    write_text,
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``eventreg identify``."""
    parser.add_argument(
        'source', metavar='BAG_OR_SCENARIO',
        help='a bag, or a scenario, which is simulated; a bag called like a scenario is ./NAME',
    )  # fmt: skip
    add_overrides(parser)
    parser.add_argument(
        '--from-signal', metavar='SIGNAL',
        help="a generator's own output, w, or a plant's, y, with the u that acts on it "
        '(w if it was recorded, else y)',
    )  # fmt: skip
    parser.add_argument(
        '--generators', type=whole(1), default=1, metavar='N', help='in the signal (1)'
    )
    parser.add_argument(
        '--affine', action='store_true', help="the sensor's gain and offset are unknown"
    )
    add_json(parser)
    parser.add_argument(
        '--out', type=Path, metavar='S.yaml', help='write a scenario whose controllers have the tau'
    )
    add_reading(parser)
    parser.add_argument(
        '--from', type=nonnegative, default=0.0, metavar='T', dest='start',
        help='model time before which nothing is used (0)',
    )  # fmt: skip
    parser.add_argument(
        '--until', type=positive, metavar='T', help='model time after which nothing is used'
    )


def main(args: argparse.Namespace) -> int:
    """Identify, print the table, write what was asked for, and return 0."""
    from ..analysis.identification.words import table
    from ..session.identified import identify, observe

    need_writable(args.json)
    need_new(args.out)
    observed = observe(
        args.source, args.scenario, args.overrides,
        namespace=args.namespace, topics=args.topics, time=args.time,
    )  # fmt: skip
    warn(observed.findings)
    part = observed.part(args.start, args.until)
    found = identify(part, args.from_signal, args.generators, args.affine)
    print(table(found), flush=True)
    write_json(args.json, found.to_dict())
    if args.out is not None:
        from ..session.identified_scenario import with_identified

        write_text(args.out, with_identified(observed.scenario, found).to_yaml())
    return 0
