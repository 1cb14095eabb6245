# SPDX-License-Identifier: Apache-2.0
"""The table of a sweep: a row per set, its parameters, its outcome; parquet or csv."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import islice
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
                yield joined(pending)
                pending, held = [], 0
    if pending:
        yield joined(pending)


def joined(
    parts: Iterable[Mapping[str, Array]], names: Sequence[str] | None = None
) -> dict[str, Array]:
    """Return one table of all the parts, with the columns ``names``, None: all. Raises KeyError."""
    kept = [{name: part[name] for name in (names or part)} for part in parts]
    return {name: np.concatenate([part[name] for part in kept]) for name in kept[0]}


def known(part: Mapping[str, Array]) -> dict[str, Array]:
    """Return a part of the table as it is read again: numbers without a verdict are NaN."""
    bad = _bad(part)
    if not bad.any():
        return dict(part)
    return {
        name: np.where(bad, np.nan, values) if name in NUMBERS else values
        for name, values in part.items()
    }


def _bad(part: Mapping[str, Array]) -> Array:
    """Return which sets of a part have no verdict, shape (n,)."""
    found: Array = part['verdict'] == None  # noqa: E711 (elementwise)
    return found


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
        bad = _bad(columns)
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
            bad = _bad(columns)
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


def read_table(path: Path, names: Sequence[str] | None = None) -> dict[str, Array]:
    """Return the columns ``names`` of a table, None: all; numbers that are not known are NaN.

    Raises KeyError for other names, EventregError for a table that cannot be read.
    """
    try:
        return (_read_csv if path.suffix == '.csv' else _read_parquet)(path, names)
    except (OSError, ValueError) as error:  # pyarrow's are these too
        reason = ' '.join(str(error).split())[:120]
        raise EventregError(
            f'cannot read {path}: {reason}; remove {path.parent} and run the sweep again'
        ) from None


def _read_csv(path: Path, names: Sequence[str] | None) -> dict[str, Array]:
    numbers = dict[str, bool]()
    while True:
        try:
            return joined(_csv_parts(path, names, numbers))
        except _NoNumberError as error:
            numbers[str(error)] = False  # begin again: all of it are words


class _NoNumberError(Exception):
    """A column, which it names, holds words."""


def _csv_parts(
    path: Path, names: Sequence[str] | None, numbers: Mapping[str, bool]
) -> Iterator[dict[str, Array]]:
    """Yield the columns of a table in parts, as numbers except where ``numbers`` says no."""
    with path.open(newline='', encoding='utf-8') as file:
        reader = csv.reader(file)
        head = next(reader)
        places = {name: head.index(name) if name in head else -1 for name in names or head}
        for name, place in places.items():
            if place < 0:
                raise KeyError(name)
        while lines := list(islice(reader, GROUP)):
            yield {
                name: _typed(name, [line[at] for line in lines], numbers.get(name, True))
                for name, at in places.items()
            }


def _typed(name: str, words: Sequence[str], number: bool) -> Array:
    if name in ('verdict', 'reason'):
        known = {word: word or None for word in words}
        return np.array([known[word] for word in words], dtype=object)
    if not number:
        return np.array(words, dtype=object)
    try:
        return np.array([float(word) if word else math.nan for word in words])
    except ValueError:
        raise _NoNumberError(name) from None


def _read_parquet(path: Path, names: Sequence[str] | None) -> dict[str, Array]:
    import pyarrow.parquet as pq

    with pq.ParquetFile(path) as file:
        known = file.schema_arrow.names
        for name in names or ():
            if name not in known:
                raise KeyError(name)
        table = file.read(columns=list(names) if names else None)
    return {name: _column(table.column(name)) for name in table.column_names}


def _column(column: Any) -> Array:
    """Return a column of pyarrow's; of words that are alike there is one."""
    if str(column.type) != 'string':
        found: Array = column.to_numpy()
        return found
    parts = []
    for part in column.chunks:
        words = part.dictionary_encode()
        known = np.array([*words.dictionary.to_pylist(), None], dtype=object)
        places = words.indices.fill_null(len(known) - 1).to_numpy(zero_copy_only=False)
        parts.append(known[places])
    return np.concatenate(parts)
