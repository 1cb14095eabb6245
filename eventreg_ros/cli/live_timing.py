"""What the nodes of a run measured of their own time, as tables."""

from __future__ import annotations

from collections.abc import Mapping

Said = Mapping[str, Mapping[str, str]]


def tables(said: Said, warnings: Mapping[str, list[str]]) -> str:
    """Return two tables, ticks by node and delays by link, and the warnings; milliseconds.

    ``said`` maps each node to the keys and values of its last diagnostics.
    """
    lines = [*_ticks(said), *_links(said)]
    for node, messages in warnings.items():
        lines.append(f'{node.strip("/")}: {messages[-1]} (warned in {len(messages)} seconds)')
    return '\n'.join(lines)


def _ticks(said: Said) -> list[str]:
    head = (
        f'{"ticks":>14} {"steps":>7} {"late p50":>9} {"p99":>8} {"max ms":>8} '
        f'{"caught up":>9} {"dropped":>8}'
    )
    rows = [
        f'{node:>14} {values["step"]:>7} {_ms(values, "lateness.p50"):>9} '
        f'{_ms(values, "lateness.p99"):>8} {_ms(values, "lateness.max"):>8} '
        f'{values["caught_up"]:>9} {values["dropped"]:>8}'
        for node, values in said.items()
        if 'lateness.p50' in values
    ]
    return [head, *rows] if rows else []


def _links(said: Said) -> list[str]:
    head = (
        f'{"links":>14} {"samples":>7} {"age p50":>9} {"p99":>8} {"max ms":>8} '
        f'{"delay max":>9} {"lost":>8} {"gaps":>5}'
    )
    rows = []
    for node, values in said.items():
        for key in values:
            signal, _, what = key.partition('.')
            if what == 'age.p50':
                rows.append(
                    f'{signal + " to " + node:>14} {values[f"{signal}.received"]:>7} '
                    f'{_ms(values, f"{signal}.age.p50"):>9} {_ms(values, f"{signal}.age.p99"):>8} '
                    f'{_ms(values, f"{signal}.age.max"):>8} '
                    f'{_ms(values, f"{signal}.delay.max"):>9} '
                    f'{values[f"{signal}.lost"]:>8} {values[f"{signal}.gaps"]:>5}'
                )
    return [head, *rows] if rows else []


def _ms(values: Mapping[str, str], key: str) -> str:
    return f'{float(values[key]) * 1e3:.3f}'
