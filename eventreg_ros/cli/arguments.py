# SPDX-License-Identifier: Apache-2.0
"""Arguments and outputs that several verbs share."""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Callable, Collection, Iterable, Mapping
from pathlib import Path
from typing import Any

from .. import scenario as scenarios
from ..bags.finding import Finding
from ..errors import EventregError, one_line
from ..files import need_writable, writing
from ..scenario import Scenario
from ..scenario.criteria import BLIND, SETTLE, WINDOW
from ..scenario.links import OPTIONS


def add_scenario(parser: argparse.ArgumentParser) -> None:
    """Add SCENARIO and its overrides."""
    parser.add_argument('scenario', metavar='SCENARIO', help='a shipped name or a .yaml file')
    add_overrides(parser)


def add_overrides(parser: argparse.ArgumentParser) -> None:
    """Add -p."""
    parser.add_argument(
        '-p', action='append', default=[], dest='overrides', metavar='NODE.PARAM:=VALUE',
        help='override a parameter; NODE may be /**; may be repeated',
    )  # fmt: skip


def load_scenario(args: argparse.Namespace, implicit: Collection[str] = ()) -> Scenario:
    """Read the scenario that :func:`add_scenario` asked for; see :func:`.scenario.load`."""
    return scenarios.load(args.scenario, args.overrides, implicit)


def add_link(parser: argparse.ArgumentParser) -> None:
    """Add --link."""
    parser.add_argument(
        '--link', action='append', default=[], dest='links', metavar='SIGNAL:NAME=VALUE,...',
        help='put a link on a signal, before all blocks that listen to it; of '
        + ', '.join(OPTIONS) + ' (seconds, probabilities); may be repeated',
    )  # fmt: skip


def add_at(parser: argparse.ArgumentParser, letter: str, unit: str) -> None:
    """Add --at, whose times are in ``unit``."""
    parser.add_argument(
        '--at', action='append', default=[], metavar=f'{letter}:ACTION',
        help=f'do something at a time in {unit}: {letter}:NODE.PARAM:=VALUE, '
        f'{letter}:NODE:deactivate or {letter}:NODE:activate; may be repeated',
    )  # fmt: skip


def add_json(parser: argparse.ArgumentParser) -> None:
    """Add --json."""
    parser.add_argument('--json', metavar='F', type=Path, help='write the result as JSON')


def add_reading(parser: argparse.ArgumentParser) -> None:
    """Add what says how a bag is read."""
    parser.add_argument(
        '--scenario', metavar='S', help='the scenario, where the bag does not hold it'
    )
    parser.add_argument('--namespace', metavar='NS', help='read the topics of this namespace')
    parser.add_argument(
        '--topic', action='append', default=[], dest='topics', metavar='SIGNAL:=TOPIC[:FIELD]',
        help='where a signal is, in messages of any type (y:=/arm/joint_states:velocity[2]); '
        'may be repeated',
    )  # fmt: skip
    parser.add_argument(
        '--time', choices=('log', 'publish', 'header'),
        help='the stamps that count (publish, where they are plausible)',
    )  # fmt: skip


def add_window(parser: argparse.ArgumentParser) -> None:
    """Add --settle and --window."""
    parser.add_argument(
        '--settle', type=nonnegative, metavar='T',
        help=f"model time before which nothing is counted (the scenario's, or {SETTLE:g})",
    )  # fmt: skip
    parser.add_argument(
        '--window', type=nonnegative, metavar='T',
        help='model time within which events of y and y_r match '
        f"(the scenario's, or {WINDOW:g})",
    )  # fmt: skip


def add_blind(parser: argparse.ArgumentParser) -> None:
    """Add --blind."""
    parser.add_argument(
        '--blind', type=positive, metavar='T',
        help='model time without a sample after which a signal counts as unseen '
        f"(the scenario's, or {BLIND:g})",
    )  # fmt: skip


def add_span(parser: argparse.ArgumentParser) -> None:
    """Add what else decides of a recording what is judged, and how strictly."""
    parser.add_argument(
        '--from', type=nonnegative, metavar='T', dest='start',
        help='model time from which on events count, instead of --settle',
    )  # fmt: skip
    parser.add_argument(
        '--until', type=positive, metavar='T',
        help='model time after which nothing is judged (the end)',
    )  # fmt: skip
    parser.add_argument(
        '--lenient', action='store_true',
        help='judge what was seen, although something is missing',
    )  # fmt: skip


def warn(findings: Iterable[Finding], run: str = '') -> None:
    """Print findings on standard error, one line each, with the name of the run if given."""
    for finding in findings:
        line = one_line(f'eventreg: {run}{": " if run else ""}{finding.text}')
        print(line, file=sys.stderr)


def nonnegative(text: str) -> float:
    """Return ``text`` as a finite float >= 0, for argparse."""
    value = float(text) if _is_number(text) else math.nan
    if not (math.isfinite(value) and value >= 0.0):
        raise argparse.ArgumentTypeError(f'must be a finite number >= 0, got {text!r}')
    return value


def positive(text: str) -> float:
    """Return ``text`` as a finite float > 0, for argparse."""
    value = float(text) if _is_number(text) else math.nan
    if not (math.isfinite(value) and value > 0.0):
        raise argparse.ArgumentTypeError(f'must be a finite number > 0, got {text!r}')
    return value


def whole(low: int) -> Callable[[str], int]:
    """Return what reads a whole number >= ``low``, for argparse."""

    def read(text: str) -> int:
        if not text.isdecimal() or int(text) < low:
            raise argparse.ArgumentTypeError(f'must be a whole number >= {low}, got {text!r}')
        return int(text)

    return read


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def write_json(path: Path | None, data: Mapping[str, Any]) -> None:
    """Write ``data`` to ``path`` unless it is None. Raises EventregError when it cannot."""
    if path is not None:
        write_text(path, json.dumps(data, indent=1, allow_nan=False) + '\n')


def write_text(path: Path, text: str) -> None:
    """Write ``text`` to ``path``. Raises EventregError when it cannot."""
    with writing(path) as file:
        file.write_text(text, encoding='utf-8', errors='replace')


def check_plot(path: Path | None) -> None:
    """Raise EventregError, before any work is done, unless a picture can be written to ``path``."""
    from ..plots.style import METADATA

    if path is None:
        return
    if path.suffix.removeprefix('.') not in METADATA or not path.suffix:
        raise EventregError(
            f'--plot must end in .{", .".join(METADATA)}, got {str(path)!r}; name another file'
        )
    need_writable(path)
