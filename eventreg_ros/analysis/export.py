# SPDX-License-Identifier: Apache-2.0
"""Signals as what other programs read: npz, csv and parquet files, pandas and xarray objects."""

from __future__ import annotations

import csv
import importlib.util
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import EventregError
from ..files import writing
from .signal import Array, Signals

if TYPE_CHECKING:
    import pandas
    import xarray

RESERVED = ('t', 'file', 'allow_pickle')


def check_path(path: Path) -> None:
    """Raise EventregError unless :func:`write_signals` can write what ``path`` ends in."""
    if path.suffix not in FORMATS:
        raise EventregError(
            f'--out must end in {" or ".join(FORMATS)}, got {str(path)!r}; name another file'
        )
    if path.suffix == '.parquet':
        need('pyarrow', f'writing {path}')


def check_names(path: Path, signals: Collection[str]) -> None:
    """Raise EventregError when a signal is called like something else in the file."""
    if clash := [name for name in signals if name in RESERVED]:
        raise EventregError(f'{path}: a signal must not be called {clash[0]!r}; rename its output')


def need(package: str, who: str) -> None:
    """Raise EventregError unless ``package``, which is optional, can be imported."""
    if importlib.util.find_spec(package) is None:
        raise EventregError(f'{who} needs {package}, which is not installed; pip install {package}')


def write_signals(path: Path, t: Array, signals: Mapping[str, Array]) -> None:
    """Write ``t`` and one array or column per signal, all of shape (n,), in ``path``'s format.

    A csv file gives every number in full, so that reading it gives the same floats. Raises
    EventregError for an unknown suffix, a signal called t, or a file that cannot be written.
    """
    check_path(path)
    check_names(path, signals)
    with writing(path) as file:
        FORMATS[path.suffix](file, t, signals)


def _npz(path: Path, t: Array, signals: Mapping[str, Array]) -> None:
    arrays: dict[str, Any] = {'t': t, **signals}
    np.savez(path, **arrays)


def _csv(path: Path, t: Array, signals: Mapping[str, Array]) -> None:
    columns = {'t': t, **signals}
    with open(path, 'w', newline='', encoding='utf-8') as file:
        writer = csv.writer(file, lineterminator='\n')
        writer.writerow(columns)
        writer.writerows(zip(*(column.tolist() for column in columns.values()), strict=True))


def _parquet(path: Path, t: Array, signals: Mapping[str, Array]) -> None:
    import pyarrow
    import pyarrow.parquet

    pyarrow.parquet.write_table(pyarrow.table({'t': t, **signals}), path)


FORMATS = {'.npz': _npz, '.csv': _csv, '.parquet': _parquet}


def to_dataframe(signals: Signals, **attrs: object) -> pandas.DataFrame:
    """Return a pandas DataFrame: a column per signal, the index t in model time.

    ``signals`` maps each name to (t, values), both of shape (n,). Where they have times of their
    own the index has them all, and a signal without a sample there is NaN; of samples at one time
    the last counts. ``attrs`` are the frame's. Raises EventregError without pandas.
    """
    need('pandas', 'to_dataframe')
    import pandas

    columns = {}
    for name, (t, x) in signals.items():
        column = pandas.Series(x, pandas.Index(t, name='t'))
        columns[name] = column[~column.index.duplicated(keep='last')]
    frame = pandas.DataFrame(columns)
    frame.index.name = 't'
    frame.attrs.update(attrs)
    return frame


def to_xarray(signals: Signals, **attrs: object) -> xarray.Dataset:
    """Return an xarray Dataset: a variable per signal over the dimension t, in model time.

    As :func:`to_dataframe`. Raises EventregError without xarray and pandas.
    """
    need('xarray', 'to_xarray')
    import xarray

    dataset: xarray.Dataset = xarray.Dataset.from_dataframe(to_dataframe(signals))
    dataset['t'].attrs['units'] = 'model time'
    dataset.attrs.update(attrs)
    return dataset
