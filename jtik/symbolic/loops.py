"""Expressions of matrices as a call with loops in it: the text of an expression does not grow with their products."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache

from jtik.symbolic.operations import MX, SX, Expression, Function, function


def looped(
    build: Callable[..., Sequence[Expression]], *arguments: Expression, when: bool = True
) -> tuple[Expression, ...]:
    """``build(*arguments)`` as a call: its products of matrices are loops over numbers.

    It is less to build and to compile than the same written out for many rows or columns, and slower for a few.

    Args:
        build: function of matrices, of their shapes alone and of nothing else; a function of a module.
        arguments: expressions (n, k) of scalars.
        when: whether it is a call; otherwise it is written out.
    """
    if not when:
        return tuple(build(*arguments))
    dense = [SX(each) for each in arguments]
    made = _function(build, tuple(each.shape for each in dense))
    return tuple(made.call(dense, False, True))


@cache
def _function(build: Callable[..., Sequence[Expression]], shapes: Sequence[tuple[int, int]]) -> Function:
    symbols = [MX.sym(f"m{i}", *shape) for i, shape in enumerate(shapes)]
    return function(build.__name__.strip("_"), symbols, build(*symbols), inline=False)
