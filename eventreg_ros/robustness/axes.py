# SPDX-License-Identifier: Apache-2.0
"""What is varied: NODE.PARAM:=SPEC read into axes, and the values that an axis takes.

    A..B/N       N values from A to B          A..B/Nlog    the same, in equal ratios
    {a,b,c}      these                         A..B         drawn uniformly
    A..Blog      drawn uniformly in log        VALUE~P%     normal, standard deviation P % of VALUE

VALUE may be a fraction, and A and B both (1/25..1/6, 1/25..1/6/20).

The last three are laws: they need a number of sets. ``links`` in the place of a node are all links
of the loop (``links.delay``, ``links.jitter`` in model time, ``links.loss``, ``links.seed``);
``noise.y`` is the standard deviation of white noise on every sample of the plant's output y.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import ParameterError, shown
from ..scenario.hint import hint
from ..scenario.reader import Override, typed

Array = npt.NDArray[Any]
"""Values of an axis: floats, or objects where they are words."""

LINKS = 'links'
OF_LINKS = ('delay', 'loss', 'jitter', 'seed')
NOISE = 'noise'
OF_RUN = (LINKS, NOISE)
"""What stands in the place of a node and is none."""

MOST_SETS = 10_000_000
"""Sets of a sweep, and so values of an axis, at most: their table takes below 2 GB."""

_NUMBER = r'[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?'
_FRACTION = r'[-+]?\d+/\d+'
_RANGE = re.compile(rf'({_NUMBER})\.\.({_NUMBER})(?:/(\d+))? ?(log)?')
_RANGE_OF_FRACTIONS = re.compile(rf'({_FRACTION})\.\.({_FRACTION}|{_NUMBER})(?:/(\d+))? ?(log)?')
_SPREAD = re.compile(rf'({_NUMBER}(?:/{_NUMBER})?)~({_NUMBER})%')
_NAME = re.compile(r'(/\*\*|[^.:\s]+)\.([^:\s[\]]+)(?:\[(\d{1,9})\])?')


@dataclass(frozen=True)
class Axis:
    """One parameter that is varied.

    ``node`` may be ``/**`` or one of :data:`OF_RUN`; ``index`` is the place in a list, None for a
    number. ``fixed``: one value that was given as such.
    ``values`` are those of a grid; without them a law maps numbers from 0 to 1 to ``low`` to
    ``high``, or around ``low`` with the standard deviation ``spread``.
    """

    name: str
    node: str
    parameter: str
    index: int | None
    values: tuple[Any, ...] = ()
    low: float = 0.0
    high: float = 0.0
    log: bool = False
    spread: float | None = None
    fixed: bool = False

    @property
    def of_run(self) -> bool:
        """Whether it is no parameter of a node."""
        return self.node in OF_RUN

    @property
    def is_law(self) -> bool:
        """Whether values are drawn rather than counted."""
        return not self.values

    def at(self, u: npt.NDArray[np.float64]) -> Array:
        """Return the values for ``u``, numbers from 0 to 1, shape (n,)."""
        if self.values:
            places = np.minimum((u * len(self.values)).astype(np.int64), len(self.values) - 1)
            return self.nth(places)
        if self.spread is not None:
            from scipy.special import ndtri

            return np.asarray(self.low + self.spread * ndtri(np.clip(u, 1e-15, 1.0 - 1e-15)))
        if self.log:
            return np.asarray(self.low * (self.high / self.low) ** u)
        return np.asarray(self.low + (self.high - self.low) * u)

    def nth(self, places: npt.NDArray[np.int64]) -> Array:
        """Return the values of the grid at ``places``, shape (n,)."""
        numbers = all(isinstance(value, float) for value in self.values)
        return np.array(self.values, dtype=np.float64 if numbers else object)[places]


def read(texts: Sequence[str]) -> tuple[list[Axis], list[str]]:
    """Sort what follows -p into axes and fixed values, the latter as they were given.

    Raises ParameterError.
    """
    found = in_order(texts)
    return (
        [each for each in found if isinstance(each, Axis)],
        [each for each in found if isinstance(each, str)],
    )


def in_order(texts: Sequence[str]) -> list[Axis | str]:
    """Return what follows -p in its order: an axis, or the text of a fixed value.

    Raises ParameterError for what is varied twice, or set once it is varied.
    """
    found: list[Axis | str] = []
    for text in texts:
        name, sign, spec = text.partition(':=')
        each = (sign and _axis(name.strip(), spec.strip(), text)) or text
        for axis in found:
            if isinstance(axis, Axis) and _sets_again(each, axis):
                raise ParameterError(f'{text}: {axis.name} is varied already; give it once')
        found.append(each)
    return found


def _sets_again(later: Axis | str, axis: Axis) -> bool:
    """Say whether nothing of an axis is left after what is given later."""
    if axis.of_run or (isinstance(later, Axis) and later.of_run):
        return isinstance(later, Axis) and later.name == axis.name
    other = later if isinstance(later, Axis) else Override.read(later)
    all_of_it = isinstance(other, Override) or other.index in (None, axis.index)
    return all_of_it and other.parameter == axis.parameter and other.node in (axis.node, '/**')


def _axis(name: str, spec: str, text: str) -> Axis | None:
    """Return the axis that is meant, None for one fixed value."""
    found = _NAME.fullmatch(name)
    if found is None:
        Override.read(text)
        raise ParameterError(
            f'a range must be NODE.PARAM:=VALUES (plant.x0[0]:=0..1/5), got {text!r}'
        )
    node, parameter, index = found.groups()
    node = node if node == '/**' else node.strip('/')
    if node == LINKS and parameter not in OF_LINKS:
        raise ParameterError(f'{text}: links have no {parameter!r}{hint(parameter, OF_LINKS)}')
    if node in OF_RUN and index is not None:
        raise ParameterError(f'{text}: {node}.{parameter} is one number; leave out [{index}]')
    place = None if index is None else int(index)
    values = _values(spec, text, parameter)
    if values is None and (node in OF_RUN or place is not None):
        values = {'values': (_word(spec, text, parameter),), 'fixed': True}
    if node in OF_RUN and not all(isinstance(v, float) for v in (values or {}).get('values', ())):
        raise ParameterError(f'{text}: {node}.{parameter} is a number, got {shown(spec)}')
    return None if values is None else Axis(name, node, parameter, place, **values)


def _values(spec: str, text: str, parameter: str) -> dict[str, Any] | None:
    if spec.startswith('{') and spec.endswith('}'):
        words = [word.strip() for word in spec[1:-1].split(',') if word.strip()]
        if not words:
            raise ParameterError(f'{text}: a list must hold values ({{1,2,3}}), got {spec!r}')
        return {'values': tuple(_word(word, text, parameter) for word in words)}
    if found := _SPREAD.fullmatch(spec):
        value, spread = _number(found[1], text), float(found[2]) / 100.0
        if not 0.0 < abs(value) * spread < math.inf:
            raise ParameterError(
                f'{text}: a spread must be > 0 and finite, got {shown(spec)}; give a range A..B'
            )
        return {'low': value, 'spread': abs(value) * spread}
    if not (found := _RANGE.fullmatch(spec) or _RANGE_OF_FRACTIONS.fullmatch(spec)):
        return None
    low, high, log = _number(found[1], text), _number(found[2], text), bool(found[4])
    if not math.isfinite(high - low):
        raise ParameterError(f'{text}: a range must be finite, got {low:g} to {high:g}')
    if log and not 0.0 < low * high < np.inf:
        raise ParameterError(f'{text}: a log range must not reach or cross 0; leave out log')
    if found[3] is None:
        return {'low': low, 'high': high, 'log': log}
    count = int(found[3]) if len(found[3]) < 10 else MOST_SETS + 1
    if not 2 <= count <= MOST_SETS:
        raise ParameterError(
            f'{text}: a range needs 2 to {MOST_SETS} values, got {shown(found[3])}'
        )
    line = np.geomspace(low, high, count) if log else np.linspace(low, high, count)
    return {'values': tuple(line.tolist())}


def _word(word: str, text: str, parameter: str = '') -> Any:
    value = typed(word, text, parameter)
    return float(value) if isinstance(value, int) and not isinstance(value, bool) else value


def _number(word: str, text: str) -> float:
    value = _word(word, text)
    if not isinstance(value, float):
        raise ParameterError(f'{text}: a range is of numbers, got {word!r}')
    return value


def spec_of(value: object) -> str:
    """Return what a value, or a list of values to try, is on a command line; a text stays."""
    if isinstance(value, list | tuple | np.ndarray):
        return f'{{{",".join(map(str, np.asarray(value, dtype=object).tolist()))}}}'
    return str(value)
