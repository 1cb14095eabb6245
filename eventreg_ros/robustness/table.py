# SPDX-License-Identifier: Apache-2.0
"""The table of a sweep: a row per set, its parameters, its outcome; parquet or csv."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import EventregError
from ..files import writing
from .axes import Array
from .design import Design
from .outcome import ROW, VERDICTS, Outcomes
from .store import Store

NUMBERS = tuple(name for name in ROW.names or () if name != 'verdict')
GROUP = 1 << 16
"""Rows that are written together, however they were run."""

Columns = Mapping[str, Array]


def batches(design: Design, store: Store) -> Iterator[dict[str, Array]]:
    """Yield the columns of all rows, in order, up to :data:`GROUP` of them at a time."""
    pending: list[dict[str, Array]] = []
    held = 0
    for stretch, outcomes in store.outcomes():
        columns = columns_of(design, stretch.first, outcomes)
        at, count = 0, len(outcomes.rows)
        while at < count:
            take = min(GROUP - held, count - at)
            pending.append({name: values[at : at + take] for name, values in columns.items()})
            at, held = at + take, held + take
            if held == GROUP:
                yield _joined(pending)
                pending, held = [], 0
    if pending:
        yield _joined(pending)


def _joined(parts: list[dict[str, Array]]) -> dict[str, Array]:
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def columns_of(design: Design, first: int, outcomes: Outcomes) -> dict[str, Array]:
    """Return the columns of a stretch of sets from ``first`` on.

    A column per axis, ``verdict`` (words, None without one), the numbers, ``reason`` (or None).
    """
    rows = outcomes.rows
    values = design.columns(first, first + len(rows))
    columns: dict[str, Array] = {
        axis.name: column for axis, column in zip(design.axes, values, strict=True)
    }
    words = np.array([word or None for word in VERDICTS], dtype=object)
    columns['verdict'] = words[rows['verdict']]
    columns |= {name: rows[name] for name in NUMBERS}
    reasons = np.full(len(rows), None, dtype=object)
    for i, text in outcomes.reasons.items():
        reasons[i] = text
    columns['reason'] = reasons
    return columns


def check_table(path: Path) -> None:
    """Raise EventregError when the table ``path`` cannot be written for want of pyarrow."""
    if path.suffix == '.csv':
        return
    try:
        import pyarrow.parquet  # noqa: F401
    except ImportError:
        raise EventregError(
            f"{path.name} needs pyarrow; pip install '.[frames]' in the sources, "
            f'or give --out a name that ends in .csv'
        ) from None


def write_table(path: Path, rows: Iterator[dict[str, Array]]) -> None:
    """Write the table; it appears whole or not at all. The same rows make the same bytes."""
    with writing(path) as file:
        (_write_csv if path.suffix == '.csv' else _write_parquet)(file, rows)


def _write_parquet(path: Path, rows: Iterator[dict[str, Array]]) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    writer = None
    for columns in rows:
        bad = columns['verdict'] == None  # noqa: E711 (elementwise)
        arrays = {name: _arrow(pa, name, values, bad) for name, values in columns.items()}
        table = pa.table(arrays)
        writer = writer or pq.ParquetWriter(path, table.schema, compression='zstd')
        writer.write_table(table)
    if writer is not None:
        writer.close()


def _arrow(pa: Any, name: str, values: Array, bad: Array) -> Any:
    """Return a column as pyarrow's; numbers of sets without a verdict are null."""
    if name in ('verdict', 'reason'):
        return pa.array(values, pa.string())
    if name in NUMBERS:
        return pa.array(values, mask=bad | _unknown(values))
    if values.dtype == object and all(isinstance(value, str) for value in values):
        return pa.array(values, pa.string())
    return pa.array(values if values.dtype != object else [str(value) for value in values])


def _unknown(values: Array) -> Array:
    return np.isnan(values) if values.dtype.kind == 'f' else np.zeros(len(values), dtype=bool)


def _write_csv(path: Path, rows: Iterator[dict[str, Array]]) -> None:
    with path.open('w', newline='', encoding='utf-8') as file:
        writer = csv.writer(file, lineterminator='\n')
        head = None
        for columns in rows:
            if head is None:
                head = list(columns)
                writer.writerow(head)
            bad = columns['verdict'] == None  # noqa: E711 (elementwise)
            writer.writerows(
                [_cell(name, value, without) for name, value in zip(head, row, strict=True)]
                for row, without in zip(
                    zip(*(values.tolist() for values in columns.values()), strict=True),
                    bad.tolist(),
                    strict=True,
                )
            )


def _cell(name: str, value: Any, without: bool) -> str:
    if value is None or (name in NUMBERS and (without or math.isnan(value))):
        return ''
    return repr(value) if isinstance(value, float) else str(value)


def read_table(path: Path) -> dict[str, Array]:
    """Return the columns of a table; numbers that are not known are NaN.

    Raises EventregError for one that cannot be read.
    """
    try:
        return _read_csv(path) if path.suffix == '.csv' else _read_parquet(path)
    except (OSError, ValueError) as error:  # pyarrow's are these too
        reason = ' '.join(str(error).split())[:120]
        raise EventregError(
            f'cannot read {path}: {reason}; remove {path.parent} and run the sweep again'
        ) from None


def _read_csv(path: Path) -> dict[str, Array]:
    with path.open(newline='', encoding='utf-8') as file:
        head, *lines = csv.reader(file)
    columns = zip(head, zip(*lines, strict=True), strict=True)
    return {name: _typed(name, column) for name, column in columns}


def _read_parquet(path: Path) -> dict[str, Array]:
    import pyarrow.parquet as pq

    table = pq.read_table(path)
    return {
        name: _typed(name, table.column(name).to_pylist())
        if name in ('verdict', 'reason')
        else table.column(name).to_numpy()
        for name in table.column_names
    }


def _typed(name: str, words: Any) -> Array:
    if name not in ('verdict', 'reason'):
        try:
            return np.array([float(word) if word else math.nan for word in words])
        except ValueError:
            return np.array(words, dtype=object)
    return np.array([word or None for word in words], dtype=object)
