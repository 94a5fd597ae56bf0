"""Parts of an expression that first derivatives leave out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias

from jtik.symbolic.operations import Expression, gradient, substitute, symbol

Hold: TypeAlias = Callable[[Expression], Expression]
"""Marks a part of an expression that first derivatives may leave out: a choice, or what the expression is least for."""


def not_held(part: Expression) -> Expression:
    """``part`` itself, which derivatives go through."""
    return part


def value_and_gradients(
    build: Callable[[Hold], Expression], variables: Sequence[Expression]
) -> tuple[Expression, list[Expression]]:
    """A scalar and its gradients, in which the held parts are constants.

    By the envelope theorem a minimum does not change to first order with the point at which it is reached. Gradients
    that hold this point take fewer operations. They have no right second derivatives.

    Args:
        build: makes the scalar; it calls its argument with the parts to hold, and uses what that returns.
        variables: symbols, columns.
    """
    held = list[tuple[Expression, Expression]]()

    def hold(part: Expression) -> Expression:
        constant = symbol("held", *part.shape)
        held.append((constant, part))
        return constant

    scalar = build(hold)
    found = [scalar, *(gradient(scalar, each) for each in variables)]
    for constant, part in reversed(held):  # a part may contain those that were held before
        found = substitute(found, [constant], [part])
    return found[0], found[1:]
