"""Rows that may give way, at a price: how a program with such rows becomes a plain one (formulations/elastic.md)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from typing import Any

from jtik.errors import ArgumentError
from jtik.symbolic import (
    Expression,
    Function,
    diag,
    fmax,
    function,
    horzcat,
    if_else,
    is_symbolic,
    symbol,
    vertcat,
    zeros,
)


@dataclass(frozen=True)
class Elastic:
    """What it costs that a row gives way by a slack s: ``price s + 1/2 curvature s^2``, 0 <= s <= give.

    Above the row's multiplier in the hard program the price keeps it hard: s is 0 wherever it can be, exactly. Each
    number is one for all rows of a group, or a column (k, 1).

    Attributes:
        price: of a unit of slack, positive; the program's unit of cost over that of the row.
        give: most slack. ``max(-lower, 0)`` and the like keep x = 0 feasible and no more.
        curvature: for slack beyond what the price forbids, so that several rows share it; the price by default.

    Raises:
        ArgumentError: for a price or curvature that is not positive, or a give below 0.
    """

    price: Any
    give: Any = inf
    curvature: Any = None

    def __post_init__(self) -> None:
        for name, least in (("price", 0), ("curvature", 0), ("give", -1e-300)):
            value = getattr(self, name)
            if isinstance(value, (int, float)) and not value > least:
                raise ArgumentError(f"elastic.{name}", value, "a number from 0" if name == "give" else "a positive one")

    def columns(self, count: int) -> list[Expression]:
        """Price, curvature and give of ``count`` rows, (count, 1) each."""
        curvature = self.price if self.curvature is None else self.curvature
        columns = []
        for name, value in (("price", self.price), ("curvature", curvature), ("give", self.give)):
            column = value if is_symbolic(value) else vertcat(*([value] if isinstance(value, (int, float)) else value))
            if column.shape == (1, 1):
                column = vertcat(*[column] * count)
            if column.shape != (count, 1):
                raise ArgumentError(f"elastic.{name}", f"shape {column.shape}", f"one number, or ({count}, 1)")
            columns.append(column)
        return columns


@dataclass(frozen=True)
class Expansion:
    """A program of ``n`` variables and ``rows`` rows, made plain: a slack variable more for each side that may give.

    Attributes: n; rows; elastic, indices of the elastic rows; below and above, positions among those that have a lower
    and an upper bound to give way: their slacks lie behind x, in this order.
    """

    n: int
    rows: int
    elastic: tuple[int, ...]
    below: tuple[int, ...]
    above: tuple[int, ...]

    @classmethod
    def of(cls, n: int, rows: int, elastic: Sequence[int], low: Expression, high: Expression) -> Expansion:
        """For bounds of all rows; a side that is infinite by construction needs no slack."""
        below = tuple(i for i, row in enumerate(elastic) if not _never(low[row]))
        above = tuple(i for i, row in enumerate(elastic) if not _never(high[row]))
        return cls(n, rows, tuple(elastic), below, above)

    @property
    def size(self) -> int:
        """Number of variables of the plain program."""
        return self.n + len(self.below) + len(self.above)

    def function(self) -> Function:
        """(P, q, C, l, u, lb, ub, price, curvature, give) -> (P, q, C, l, u, lb, ub) of the plain program."""
        n, k, e = self.n, self.rows, len(self.elastic)
        sizes = ((n, n), (n, 1), (k, n), (k, 1), (k, 1), (n, 1), (n, 1), (e, 1), (e, 1), (e, 1))
        given = [symbol(f"d{i}", *size) for i, size in enumerate(sizes)]
        P, q, C, low, high, lower, upper, price, curvature, give = given
        m, sides = self.size - n, [*self.below, *self.above]
        signs = [1] * len(self.below) + [-1] * len(self.above)
        slack = zeros(k, m)
        for column, (side, sign) in enumerate(zip(sides, signs, strict=True)):
            slack[self.elastic[side], column] = sign
        P = vertcat(horzcat(P, zeros(n, m)), horzcat(zeros(m, n), diag(curvature[sides])))
        bounds = vertcat(lower, zeros(m)), vertcat(upper, give[sides])
        plain = [P, vertcat(q, price[sides]), horzcat(C, slack), low, high, *bounds]
        return function("elastic", given, plain)


def mispriced(slack: Expression, multipliers: Expression, columns: Sequence[Expression], accuracy: float) -> Expression:
    """How far multipliers are from what the slacks (e, 1) cost, relative to the price: 0 at the optimum.

    A slack that could be larger has a multiplier of at most price + curvature s, one that could be smaller at least
    that; what is nearer to an end than ``accuracy`` is there.
    """
    price, curvature, give = columns
    worst: Expression = 0
    for i in range(slack.shape[0]):
        s, y = slack[i], fmax(multipliers[i], -multipliers[i])
        excess = (y - price[i] - curvature[i] * s) / (1 + price[i])
        worst = fmax(worst, if_else(s < give[i] - accuracy, excess, 0))
        worst = fmax(worst, if_else(s > accuracy, -excess, 0))
    return worst


def _never(bound: Expression) -> bool:
    """Whether a bound is infinite whatever the numbers."""
    return bool(bound.is_constant()) and abs(float(bound)) == inf
