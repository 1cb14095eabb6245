"""``eventreg simulate``: the scenario offline, as one continuous system or as the nodes do it."""

from __future__ import annotations

import argparse
import math
from pathlib import Path

from ..errors import EventregError
from ..scenario import Scenario
from .arguments import (
    add_json,
    add_scenario,
    add_window,
    load_scenario,
    nonnegative,
    positive,
    write_json,
)

IMPAIRMENTS = {'delay': 0.0, 'loss': 0.0, 'jitter': 0.0, 'seed': 0}
FORMATS = ('.npz', '.csv')

FINE = 0.02
"""Model time between the samples in which a continuous run's events are looked for, at most.

Interpolated linearly, they are then within 1e-3 of the true ones in every shipped scenario.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``eventreg simulate``."""
    add_scenario(parser)
    parser.add_argument(
        '--duration', type=positive, default=400.0, metavar='T', help='model time (400)'
    )
    parser.add_argument(
        '--sampled', action='store_true', help='sample by sample, as the nodes do it in lockstep'
    )
    parser.add_argument(
        '--delay', type=nonnegative, metavar='D', help='of every link, model time (0); --sampled'
    )
    parser.add_argument(
        '--loss', type=_probability, metavar='P', help='probability per sample (0); --sampled'
    )
    parser.add_argument(
        '--jitter', type=nonnegative, metavar='J',
        help='extra delay of each sample, uniform from 0 to J, model time (0); --sampled',
    )  # fmt: skip
    parser.add_argument(
        '--seed', type=_whole, metavar='N', help='of loss and jitter (0); --sampled'
    )
    parser.add_argument('--out', type=Path, metavar='F', help='write the signals: .npz or .csv')
    parser.add_argument('--bag', type=Path, metavar='DIR', help='write the signals as a rosbag2')
    add_json(parser)
    add_window(parser)


def main(args: argparse.Namespace) -> int:
    """Run ``eventreg simulate`` and return the verdict's exit code."""
    from ..analysis.verdict import EXIT_CODES, judge, table

    given = {name: getattr(args, name) for name in IMPAIRMENTS if getattr(args, name) is not None}
    _check(args, list(given))
    scenario = load_scenario(args)
    fine, every = (_sampled if args.sampled else _continuous)(scenario, args.duration, given)
    t, signals = fine.t[::every], {name: x[::every] for name, x in fine.signals.items()}
    if args.out is not None:
        from ..simulation.files import write_signals

        write_signals(args.out, t, signals)
    return 0
