# SPDX-License-Identifier: Apache-2.0
"""What a parameter is: name, ROS type, default, rule, and when it may be set."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from ..errors import ParameterError, shown

START, UNCONFIGURED, INACTIVE, ACTIVE = 'started', 'unconfigured', 'inactive', 'active'
"""Until when a parameter may be set: as the node is started only, or in a state of its life."""

Value = bool | int | float | str | list[float] | list[str]


@dataclass(frozen=True)
class Parameter:
    """One parameter: its ROS type, default, meaning and rule.

    ``type`` is one of bool, int, double, string, double[], string[]. ``low`` is the least value
    allowed, or the bound that it must exceed when ``open_low``; ``settable`` says until which state
    of the node it may be set: :data:`UNCONFIGURED`, :data:`INACTIVE` or :data:`ACTIVE`. One that
    names a file is :data:`START`: only who starts the node says which files it reads and writes. A
    list has ``length`` entries, or at most ``most``.
    """

    name: str
    type: str
    default: Any
    doc: str
    low: float | None = None
    open_low: bool = False
    high: float | None = None
    choices: tuple[str, ...] | Callable[[], tuple[str, ...]] = ()
    length: int | None = None
    most: int = 10_000
    settable: str = INACTIVE

    @property
    def allowed(self) -> tuple[str, ...]:
        """The words that it may be, () where it is not one of a few."""
        return self.choices() if callable(self.choices) else self.choices

    @property
    def rule(self) -> str:
        """The rule in words, as errors and ``ros2 param describe`` show it."""
        words = {
            'bool': 'true or false',
            'int': 'a whole number',
            'double': 'a finite number',
            'string': 'a string',
            'double[]': 'a list of finite numbers',
            'string[]': 'a list of strings',
        }[self.type]
        if self.type.endswith('[]') and self.length is None:
            words = words.replace('of', f'of at most {self.most}')
        if self.choices:
            words = 'one of ' + ', '.join(self.allowed)
        if self.low is not None:
            words += f' {">" if self.open_low else ">="} {self.low:g}'
        if self.high is not None:
            words += f'{" and" if self.low is not None else ""} <= {self.high:g}'
        if self.length is not None:
            words += f' of length {self.length}'
        return words

    def check(self, where: str, value: Any) -> Value:
        """Return ``value`` in the parameter's type.

        Whole numbers are taken where a double is meant. Raises ParameterError that names ``where``.
        """
        try:
            result: Value = _convert(self.type, value)
            if self._allows(result):
                return result
        except (TypeError, ValueError, OverflowError):
            pass
        meant = value if isinstance(value, list) else [value]
        words = self.type.startswith('string') and any(isinstance(word, bool) for word in meant)
        quote = "; quote words that YAML takes for true or false, like 'y'" if words else ''
        raise ParameterError(f'{where}.{self.name} must be {self.rule}, got {shown(value)}{quote}')

    def _allows(self, value: Value) -> bool:
        if self.choices:
            return value in self.allowed
        if isinstance(value, list) and len(value) > self.most:
            return False
        if self.length is not None and len(value) != self.length:  # type: ignore[arg-type]
            return False
        if isinstance(value, bool | str | list):
            return True
        if self.low is not None and not (value > self.low if self.open_low else value >= self.low):
            return False
        return self.high is None or value <= self.high


def _convert(kind: str, value: Any) -> Any:
    if kind.endswith('[]'):
        if value is None:  # an empty list has no type in ROS's parameter files
            return []
        if hasattr(value, 'tolist'):  # the arrays that rclpy hands over
            value = value.tolist()
        if isinstance(value, str | bytes) or not isinstance(value, Sequence):
            raise TypeError
        # [''] is how ROS users write an empty list of names.
        return [_convert(kind[:-2], item) for item in value if item != '']
    if kind == 'double':
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise TypeError
        if not math.isfinite(value):
            raise ValueError
        return float(value)
    wanted = {'bool': bool, 'int': int, 'string': str}[kind]
    if type(value) is not wanted:
        raise TypeError
    return value
