# SPDX-License-Identifier: Apache-2.0
"""What numba computes in another way than Python, done Python's way in the code of other packages.

numba makes a product of ``x ** 3``, LLVM one of ``pow(x, 2.0)``; numpy's functions have other bits
than those of the same name in ``math``, and where Python raises, compiled code goes on with
infinity. In the functions that :func:`pipeline` compiles, a power is that of C's library, as in
Python; a number where Python would raise is NaN, which stays; what cannot be the same is refused.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator
from functools import lru_cache
from types import BuiltinFunctionType, FunctionType, ModuleType
from typing import Any

from .python_arithmetic import DIVISIONS, replacements

OTHER = frozenset({'dist', 'fsum', 'gamma', 'hypot', 'ldexp', 'lgamma'})
"""Functions of ``math`` that are Python's own, or raise an error where C's do not."""

OF_NUMPY = frozenset(
    {'abs', 'absolute', 'ceil', 'e', 'fabs', 'floor', 'inf', 'maximum', 'minimum', 'nan', 'pi'}
    | {'sign', 'sqrt'}
)
"""What of numpy has Python's bits, but for two things. ``maximum`` and ``minimum`` of two zeros may
have another sign; and where numpy's numbers overflow to infinity, without an error, NaN comes."""


def is_foreign(function: FunctionType) -> bool:
    """Say whether a function is of another package; what is generated here has no module."""
    return (function.__module__ or 'eventreg_ros').partition('.')[0] not in _OURS


_OURS = ('eventreg_ros', 'builtins')


@lru_cache(maxsize=1)
def pipeline() -> Any:
    """Return the compiler, for numba's ``pipeline_class``, that keeps to Python's bits.

    It raises an error of numba's for what it refuses. What it is made of numba promises to nobody:
    with another numba anything may be raised, here or by the compiler.
    """
    from numba.core.compiler import CompilerBase, DefaultPassBuilder
    from numba.core.compiler_machinery import FunctionPass, register_pass
    from numba.core.untyped_passes import InlineClosureLikes

    instead = replacements()

    @register_pass(mutates_CFG=False, analysis_only=False)
    class Python(FunctionPass):
        """Puts what is done Python's way in place of what numba would do."""

        _name = 'eventreg_same_bits'

        def __init__(self) -> None:
            FunctionPass.__init__(self)

        def run_pass(self, state: Any) -> bool:
            return _replace(state.func_ir, instead)

    class Compiler(CompilerBase):
        def define_pipelines(self) -> list[Any]:
            passes = DefaultPassBuilder.define_nopython_pipeline(self.state)
            passes.add_pass_after(Python, InlineClosureLikes)  # with comprehensions
            passes.finalize()
            return [passes]

    return Compiler


def _replace(func_ir: Any, instead: dict[Any, FunctionType]) -> bool:
    """Replace in numba's form of a function; say whether anything was."""
    from numba.core.ir_utils import build_definitions

    changed = False
    for block in func_ir.blocks.values():
        body: list[Any] = []
        for statement in block.body:
            new = list(_rewritten(func_ir, block.scope, statement, instead))
            changed = changed or new != [statement]
            body += new
        block.body = body
    if changed:
        func_ir._definitions = build_definitions(func_ir.blocks)
    return changed


def _rewritten(
    func_ir: Any, scope: Any, statement: Any, instead: dict[Any, FunctionType]
) -> Iterator[Any]:
    """Yield what takes the place of a statement."""
    from numba.core import ir
    from numba.core.errors import UnsupportedError

    value = statement.value if isinstance(statement, ir.Assign) else None
    function = None
    if isinstance(value, ir.Expr) and value.op == 'make_function':
        raise UnsupportedError('a function inside of a function is compiled without this')
    if isinstance(value, ir.Expr) and value.op in ('binop', 'inplace_binop'):
        fn = value.fn if value.op == 'binop' else value.immutable_fn
        function = None if _safe(func_ir, fn, value.rhs) else instead.get(fn)
        if function is not None:
            name = scope.redefine('$same_bits', statement.loc)
            yield ir.Assign(ir.Global(function.__name__, function, statement.loc), name, value.loc)
            call = ir.Expr.call(name, [value.lhs, value.rhs], (), statement.loc)
            yield ir.Assign(call, statement.target, statement.loc)
            return
    elif value is not None and (named := _named(func_ir, value)) is not None:
        _need_same(named)
        function = instead.get(named) if callable(named) and isinstance(named, Hashable) else None
    if function is not None:
        value = ir.Global(function.__name__, function, statement.loc)
        statement = ir.Assign(value, statement.target, statement.loc)
    yield statement


def _safe(func_ir: Any, fn: Any, divisor: Any) -> bool:
    """Say whether it is a division by a number that is written there."""
    from numba.core import ir
    from numba.core.ir_utils import get_definition, guard

    found = guard(get_definition, func_ir, divisor)
    return fn in DIVISIONS and isinstance(found, ir.Const) and found.value != 0


def _named(func_ir: Any, value: Any) -> Any:
    """Return the function that an expression names: of ``math`` or numpy, or ``pow``; or None."""
    from numba.core import ir
    from numba.core.ir_utils import get_definition, guard

    if isinstance(value, ir.Expr) and value.op == 'getattr':
        home = guard(get_definition, func_ir, value.value)
        module = home.value if isinstance(home, ir.Global | ir.FreeVar) else None
        return getattr(module, value.attr, None) if isinstance(module, ModuleType) else None
    return value.value if isinstance(value, ir.Global | ir.FreeVar) else None


def _need_same(named: Any) -> None:
    """Raise numba's error for a function whose bits cannot be Python's."""
    from numba.core.errors import UnsupportedError

    name, home = getattr(named, '__name__', ''), getattr(named, '__module__', None) or ''
    of_numpy = type(named).__module__.partition('.')[0] == 'numpy' or home.startswith('numpy')
    if (of_numpy and callable(named) and name not in OF_NUMPY) or (
        isinstance(named, BuiltinFunctionType)
        and (home == 'cmath' or (home == 'math' and name in OTHER))
    ):
        raise UnsupportedError(f'{home}.{name} compiled has other bits than in Python')
