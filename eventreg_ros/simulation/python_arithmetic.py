# SPDX-License-Identifier: Apache-2.0
"""Powers, divisions and functions of ``math`` as Python has them, for code that numba compiles.

A whole number of Python's has any size, so where it comes of a float or of a power it stays a float
here: the same number up to 2^53, and one that numba refuses as an index.
"""

from __future__ import annotations

import math
import operator
from typing import Any

MAY_RAISE = (
    'acosh', 'atanh', 'cosh', 'exp', 'exp2', 'expm1', 'log', 'log10', 'log1p', 'log2', 'sinh',
)  # fmt: skip
"""Functions of ``math`` that Python lets overflow or reach a pole with an error."""


def power(a: float, b: float) -> Any:
    """Return a to the power b; what compiled code calls in place of ``**``."""
    return a**b


def power_of_floats(a: float, b: float) -> float:
    """Return the same as :func:`math.pow` does it."""
    return math.pow(a, b)


def _divided(a: float, b: float) -> float:
    return a / b


def _divided_or_nan(a: float, b: float) -> float:
    return a / b if b != 0 else math.nan


def _whole(a: float, b: float) -> float:
    return a // b


def _whole_or_nan(a: float, b: float) -> float:
    return a // b if b != 0 else math.nan


def _rest(a: float, b: float) -> float:
    return a % b


def _rest_or_nan(a: float, b: float) -> float:
    return a % b if b != 0 else math.nan


def _whole_part(x: float) -> Any:
    return int(x)


def _rounded(x: float, digits: Any = None) -> Any:
    return round(x, digits)


def _sign(x: float) -> float:
    return 1.0 if x > 0 else -1.0 if x < 0 else 0.0 if x == 0 else math.nan


DIVISIONS: dict[Any, tuple[Any, Any]] = {
    operator.truediv: (_divided, _divided_or_nan),
    operator.floordiv: (_whole, _whole_or_nan),
    operator.mod: (_rest, _rest_or_nan),
}
"""Each division, as a function that numba does not know, and what it then does."""


def replacements() -> dict[Any, Any]:
    """Return what is replaced, each with the function that numba finds in its place."""
    import numpy as np

    raised = _always(_raised(_opaque()))
    _teach(power, raised)
    _teach(power_of_floats, raised)
    found: dict[Any, Any] = {operator.pow: power, pow: power, math.pow: power_of_floats}
    found |= {int: _teach(_whole_part, _to_whole(int, np.trunc)), round: _teach(_rounded, _round)}
    for name, like in {'trunc': np.trunc, 'floor': np.floor, 'ceil': np.ceil}.items():
        function = getattr(math, name)
        found[function] = _teach(_stub(name), _to_whole(function, like))
    found[np.sign] = _teach(_sign, _each(_sign))
    for operation, (division, checked) in DIVISIONS.items():
        found[operation] = _teach(division, _always(checked))
    for name in MAY_RAISE:
        function = getattr(math, name, None)  # exp2 came with Python 3.11
        if function is not None:
            found[function] = _teach(_stub(name), _checking(function))
    return found


def _teach(function: Any, implementations: Any) -> Any:
    """Tell numba what ``function`` does, by the types that it is given; return it."""
    from numba.extending import overload

    overload(function, jit_options={'error_model': 'numpy'})(implementations)
    return function


def _is_float(kind: Any) -> bool:
    from numba.core.types import Float

    return isinstance(kind, Float)


def _raised(opaque: Any) -> Any:
    def raised(a: float, b: float) -> Any:
        base, exponent = float(a), float(b)
        found = opaque(base) ** opaque(exponent)
        if math.isinf(found) and math.isfinite(base) and math.isfinite(exponent):
            return math.nan
        return found

    return raised


def _always(implementation: Any) -> Any:
    def implementations(a: float, b: float) -> Any:
        return implementation

    return implementations


def _each(implementation: Any) -> Any:
    def implementations(x: float) -> Any:
        return implementation

    return implementations


def _to_whole(function: Any, like: Any) -> Any:
    """Return what numba does for ``function``; of floats it is ``like`` it, NaN where it raises."""

    def as_float(x: float) -> Any:
        found = like(x)
        return (found - found) + found

    def as_it_is(x: float) -> Any:
        return function(x)

    def implementations(x: float) -> Any:
        return as_float if _is_float(x) else as_it_is

    return implementations


def _round(x: float, digits: Any = None) -> Any:
    import numpy as np

    def to_digits(x: float, digits: Any = None) -> Any:
        return round(x, digits)

    def to_whole(x: float, digits: Any = None) -> Any:
        found = np.rint(x)
        return (found - found) + found

    return to_digits if getattr(digits, 'signed', None) is not None else to_whole


def _stub(name: str) -> Any:
    def stub(x: float) -> Any:
        return getattr(math, name)(x)

    stub.__name__ = name
    return stub


def _checking(function: Any) -> Any:
    def checked(x: float) -> Any:
        found = function(float(x))
        if math.isinf(found) and math.isfinite(x):
            return math.nan
        return found

    def implementations(x: float) -> Any:
        return checked

    return implementations


def _opaque() -> Any:
    """Return a function that gives a number back such that LLVM knows nothing about it."""
    from llvmlite import ir
    from numba.core import types
    from numba.extending import intrinsic

    @intrinsic
    def opaque(context: Any, x: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            whole = ir.IntType(64)
            bits = builder.bitcast(arguments[0], whole)
            same = ir.FunctionType(whole, [whole])
            return builder.bitcast(builder.asm(same, '', '=r,0', [bits], False), ir.DoubleType())

        return types.float64(types.float64), code

    return opaque
