# SPDX-License-Identifier: Apache-2.0
"""What the nodes of a run measured of their own time, as tables."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from ..runtime.figures import LATE, Percentiles, TickFigures, inputs_in

_LEAD = re.compile(r'set -p /\*\*\.lead:=(\d+(?:\.\d+)?)')

Measured = Mapping[str, Mapping[str, str]]


def matters(warnings: Mapping[str, Sequence[str]]) -> dict[str, list[str]]:
    """Return the warnings that can have to do with the verdict: all but those of late ticks alone.

    A tick so late that the loop feels it makes a measured delay, and that is warned of by itself.
    """
    kept = {
        node: [m for m in messages if not all(p.startswith(LATE) for p in m.split('; '))]
        for node, messages in warnings.items()
    }
    return {node: messages for node, messages in kept.items() if messages}


def short_leads(warnings: Mapping[str, Sequence[str]]) -> list[str]:
    """Return, for each node to which samples came after their time, the lead that covers it."""
    lines = []
    for node, messages in warnings.items():
        needed = [float(lead) for m in messages for lead in _LEAD.findall(m)]
        if needed:
            lines.append(
                f'{node.strip("/")}: in {len(needed)} seconds samples came after their time; '
                f'set -p /**.lead:={max(needed):g}'
            )
    return lines


def tables(measured: Measured, warnings: Mapping[str, Sequence[str]]) -> str:
    """Return two tables, ticks by node and delays by link, and the warnings; milliseconds.

    ``measured`` maps each node to the keys and values of its last diagnostics.
    """
    lines = [*_ticks(measured), *_links(measured)]
    for node, messages in warnings.items():
        lines.append(f'{node.strip("/")}: {messages[-1]} (warned in {len(messages)} seconds)')
    return '\n'.join(lines)


def _ticks(measured: Measured) -> list[str]:
    head = (
        f'{"ticks":>14} {"steps":>7} {"late p50":>9} {"p99":>8} {"max ms":>8} '
        f'{"caught up":>9} {"dropped":>8}'
    )
    figures = {node: TickFigures.read(values) for node, values in measured.items()}
    rows = [
        f'{node:>14} {f.step:>7} {_ms(f.lateness)} {f.caught_up:>9} {f.dropped:>8}'
        for node, f in figures.items()
        if f is not None
    ]
    return [head, *rows] if rows else []


def _links(measured: Measured) -> list[str]:
    head = (
        f'{"links":>14} {"samples":>7} {"age p50":>9} {"p99":>8} {"max ms":>8} '
        f'{"delay max":>9} {"lost":>8} {"gaps":>5}'
    )
    rows = [
        f'{signal + " to " + node:>14} {f.received:>7} {_ms(f.age)} '
        f'{f.delay.largest * 1e3:>9.3f} {f.lost:>8} {f.gaps:>5}'
        for node, values in measured.items()
        for signal, f in inputs_in(values).items()
        if f.age is not None and f.delay is not None
    ]
    return [head, *rows] if rows else []


def _ms(span: Percentiles) -> str:
    return f'{span.p50 * 1e3:>9.3f} {span.p99 * 1e3:>8.3f} {span.largest * 1e3:>8.3f}'
