"""Signals as files that other programs read: npz and csv."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import EventregError

Array = npt.NDArray[np.float64]
RESERVED = ('t', 'file', 'allow_pickle')


def check_path(path: Path) -> None:
    """Raise EventregError unless :func:`write_signals` knows the suffix of ``path``."""
    if path.suffix not in FORMATS:
        raise EventregError(
            f'--out must end in {" or ".join(FORMATS)}, got {str(path)!r}; name another file'
        )


def write_signals(path: Path, t: Array, signals: Mapping[str, Array]) -> None:
    """Write ``t`` and one array or column per signal, all of shape (n,), in ``path``'s format.

    A csv file gives every number in full, so that reading it gives the same floats. Raises
    EventregError for an unknown suffix, a signal called t, or a file that cannot be written.
    """
    check_path(path)
    if clash := [name for name in signals if name in RESERVED]:
        raise EventregError(f'{path}: a signal must not be called {clash[0]!r}; rename its output')
    try:
        FORMATS[path.suffix](path, t, signals)
    except OSError as error:
        raise EventregError(f'cannot write {path}: {error.strerror}; name another file') from None


def _npz(path: Path, t: Array, signals: Mapping[str, Array]) -> None:
    arrays: dict[str, Any] = {'t': t, **signals}
    np.savez(path, **arrays)


def _csv(path: Path, t: Array, signals: Mapping[str, Array]) -> None:
    columns = {'t': t, **signals}
    with open(path, 'w', newline='', encoding='utf-8') as file:
        writer = csv.writer(file, lineterminator='\n')
        writer.writerow(columns)
        writer.writerows(zip(*(column.tolist() for column in columns.values()), strict=True))


FORMATS = {'.npz': _npz, '.csv': _csv}
