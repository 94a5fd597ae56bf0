"""Elastic rows: constraints that may be relaxed by a slack with a penalty (formulations/elastic.md)."""

from __future__ import annotations

import warnings
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
    vec,
    vertcat,
    zeros,
)


@dataclass(frozen=True, init=False)
class Elastic:
    """The penalty ``penalty s + 1/2 curvature s^2``, 0 <= s <= max_slack, of relaxing a row by the slack s.

    Prefer it to a hard row where rows may contradict each other. A penalty above the row's multiplier in the hard QP is
    exact: s is 0 wherever the row can be satisfied. Each argument is one number for all rows of a group, or a
    column (k, 1).

    Args:
        penalty: penalty weight of a unit of slack, positive, in the QP's unit of cost over the row's unit.
        max_slack: upper bound of the slack, non-negative, in the row's unit. ``max(-lower, 0)`` and the like are the
            smallest with which x = 0 is feasible.
        curvature: weight of the quadratic penalty, positive, so that several relaxed rows share the slack;
            ``penalty`` by default.
        price: deprecated name of ``penalty``.
        give: deprecated name of ``max_slack``.

    Raises:
        ArgumentError: if penalty or curvature is not positive, or max_slack is negative.
    """

    penalty: Any
    max_slack: Any
    curvature: Any

    def __init__(
        self, penalty: Any = None, max_slack: Any = None, curvature: Any = None, *, price: Any = None, give: Any = None
    ) -> None:
        for old, new, value in (("price", "penalty", price), ("give", "max_slack", give)):
            if value is not None:
                _deprecated(old, new)
        penalty = price if penalty is None else penalty
        max_slack = give if max_slack is None else max_slack
        if penalty is None:
            raise ArgumentError("elastic.penalty", None, "a positive number, or one for each row")
        object.__setattr__(self, "penalty", penalty)
        object.__setattr__(self, "max_slack", inf if max_slack is None else max_slack)
        object.__setattr__(self, "curvature", curvature)
        for name in ("penalty", "curvature"):
            value = getattr(self, name)
            if isinstance(value, (int, float)) and not value > 0:
                raise ArgumentError(f"elastic.{name}", value, "a positive number")
        if isinstance(self.max_slack, (int, float)) and not self.max_slack >= 0:
            raise ArgumentError("elastic.max_slack", self.max_slack, "a non-negative number")

    @property
    def price(self) -> Any:
        """Deprecated name of `penalty`."""
        _deprecated("price", "penalty")
        return self.penalty

    @property
    def give(self) -> Any:
        """Deprecated name of `max_slack`."""
        _deprecated("give", "max_slack")
        return self.max_slack

    def columns(self, count: int) -> list[Expression]:
        """Penalty, curvature and largest slack of ``count`` rows, (count, 1) each.

        Args:
            count: number of rows.

        Raises:
            ArgumentError: when one of them is neither one number nor a column (count, 1).
        """
        curvature = self.penalty if self.curvature is None else self.curvature
        columns = []
        for name, value in (("penalty", self.penalty), ("curvature", curvature), ("max_slack", self.max_slack)):
            column = value if is_symbolic(value) else vertcat(*([value] if isinstance(value, (int, float)) else value))
            if column.shape == (1, 1):
                column = vertcat(*[column] * count)
            if column.shape != (count, 1):
                raise ArgumentError(f"elastic.{name}", f"shape {column.shape}", f"one number, or ({count}, 1)")
            columns.append(column)
        return columns


@dataclass(frozen=True)
class SlackExpansion:
    """How a QP with elastic rows becomes one with hard rows: one slack variable more for each side of an elastic row.

    Attributes:
        n: number of variables without slacks.
        rows: number of rows.
        elastic: indices of the elastic rows.
        below: positions among the elastic rows of those with a lower bound; their slacks follow x.
        above: positions among the elastic rows of those with an upper bound; their slacks come last.
    """

    n: int
    rows: int
    elastic: tuple[int, ...]
    below: tuple[int, ...]
    above: tuple[int, ...]

    @classmethod
    def of(cls, n: int, rows: int, elastic: Sequence[int], low: Expression, high: Expression) -> SlackExpansion:
        """From the bounds of all rows; a bound that is infinite by construction needs no slack."""
        below = tuple(i for i, row in enumerate(elastic) if not _always_infinite(low[row]))
        above = tuple(i for i, row in enumerate(elastic) if not _always_infinite(high[row]))
        return cls(n, rows, tuple(elastic), below, above)

    @property
    def size(self) -> int:
        """Number of variables including slacks."""
        return self.n + len(self.below) + len(self.above)

    def function(self) -> Function:
        """(P, q, C, l, u, lb, ub, penalty, curvature, max_slack) -> (P, q, C, l, u, lb, ub) with slack variables."""
        n, k, e = self.n, self.rows, len(self.elastic)
        sizes = ((n, n), (n, 1), (k, n), (k, 1), (k, 1), (n, 1), (n, 1), (e, 1), (e, 1), (e, 1))
        given = [symbol(f"d{i}", *size) for i, size in enumerate(sizes)]
        P, q, C, low, high, lower, upper, penalty, curvature, max_slack = given
        m, sides = self.size - n, [*self.below, *self.above]
        signs = [1] * len(self.below) + [-1] * len(self.above)
        slack = zeros(k, m)
        for column, (side, sign) in enumerate(zip(sides, signs, strict=True)):
            slack[self.elastic[side], column] = sign
        # entries of a column of one entry are a row
        penalty, curvature, max_slack = (vec(column[sides]) for column in (penalty, curvature, max_slack))
        P = vertcat(horzcat(P, zeros(n, m)), horzcat(zeros(m, n), diag(curvature)))
        bounds = vertcat(lower, zeros(m)), vertcat(upper, max_slack)
        expanded = [P, vertcat(q, penalty), horzcat(C, slack), low, high, *bounds]
        return function("elastic", given, expanded)


def multiplier_error(
    slack: Expression, multipliers: Expression, columns: Sequence[Expression], accuracy: float
) -> Expression:
    """Violation of the optimality conditions of the slacks (e, 1), relative to the penalty: 0 at the optimum.

    The multiplier of a slack below its upper bound is at most penalty + curvature s, that of a positive slack at least
    as much. A slack within ``accuracy`` of a bound counts as being at it.
    """
    penalty, curvature, max_slack = columns
    worst: Expression = 0
    for i in range(slack.shape[0]):
        s, y = slack[i], fmax(multipliers[i], -multipliers[i])
        excess = (y - penalty[i] - curvature[i] * s) / (1 + penalty[i])
        worst = fmax(worst, if_else(s < max_slack[i] - accuracy, excess, 0))
        worst = fmax(worst, if_else(s > accuracy, -excess, 0))
    return worst


def _always_infinite(bound: Expression) -> bool:
    """Whether a bound is an infinite constant."""
    return bool(bound.is_constant()) and abs(float(bound)) == inf


def _deprecated(old: str, new: str) -> None:
    """Warn about a deprecated argument or attribute of Elastic."""
    warnings.warn(f"Elastic: {old!r} is deprecated; use {new!r}", DeprecationWarning, stacklevel=3)
