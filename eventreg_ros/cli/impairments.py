# SPDX-License-Identifier: Apache-2.0
"""The deliberate impairments of a simulation: delay, loss, jitter, and noise."""

from __future__ import annotations

import argparse
import math
import sys
from typing import Any

from ..errors import EventregError
from ..scenario import Scenario
from ..scenario.leads import unequal_leads
from .arguments import nonnegative, whole

IMPAIRMENTS = ('delay', 'loss', 'jitter', 'noise', 'seed', 'on')


def add_impairments(parser: argparse.ArgumentParser) -> None:
    """Add the options, which are None unless they are given."""
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
        '--noise', type=nonnegative, metavar='SD',
        help="white noise on every sample of a plant's output: its standard deviation (0)",
    )  # fmt: skip
    parser.add_argument('--seed', type=whole(0), metavar='N', help='of loss, jitter and noise (0)')
    parser.add_argument(
        '--on', type=signal_names, metavar='SIGNAL,...',
        help='the signals whose links are impaired (all); --sampled',
    )  # fmt: skip


def impairments(args: argparse.Namespace) -> dict[str, Any]:
    """Return those that were given, by name. Raises EventregError for those that need --sampled."""
    given = {name: getattr(args, name) for name in IMPAIRMENTS}
    given = {name: value for name, value in given.items() if value is not None}
    free = {'noise', 'seed'} if 'noise' in given else set()
    bound = [name for name in given if name not in free]
    if bound and not args.sampled:
        raise EventregError(
            f'--{bound[0]} needs --sampled: without it the loop is one continuous system '
            f'that has no links; add --sampled'
        )
    return given


def warn_of_leads(scenario: Scenario) -> None:
    """Say on standard error where plant and predicting controller have another ``lead``."""
    for line in unequal_leads(scenario):
        print(f'eventreg: {line}', file=sys.stderr)


def warn_of_rounding(delay: float | None, scenario: Scenario) -> None:
    """Say on standard error which delay, in model time, was simulated instead of ``delay``."""
    h = scenario.time_scale / scenario.rate
    if not math.isfinite((delay or 0.0) / h):
        return
    used = round((delay or 0.0) / h) * h
    if abs(used - (delay or 0.0)) > 1e-9 * h:
        print(
            f'eventreg: --delay {delay:g} was rounded to {used:g}, whole steps of {h:g}; '
            f'a higher rate has finer ones',
            file=sys.stderr,
        )


def signal_names(text: str) -> list[str]:
    """Return the signals that ``text`` names, for argparse."""
    names = [name for name in text.split(',') if name]
    if not names:
        raise argparse.ArgumentTypeError(f'must name signals (y,u), got {text!r}')
    return names


def _probability(text: str) -> float:
    value = nonnegative(text)
    if value > 1.0:
        raise argparse.ArgumentTypeError(f'must be a probability from 0 to 1, got {text!r}')
    return value
