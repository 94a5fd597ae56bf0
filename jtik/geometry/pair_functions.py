"""Distances of a body to an obstacle as functions that are built once, and called for every pair."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

from jtik.symbolic import Expression, Function, function, symbol
from jtik.symbolic.held import value_and_gradients

LARGE = 150
"""Instructions above which a function is called in an expression rather than copied into it.

A call takes as long as some 40 instructions, and building an expression takes time in proportion to its size.
"""


@dataclass(frozen=True)
class Distances:
    """Distances to one obstacle as expressions.

    Attributes:
        kind: name of its kind.
        distance: (points, figures, hold) -> signed distance [m] of one point (d, 1) [m], or of the segment between two.
        figures: what the distance is computed from, columns.
        rounding: radius of the ball that rounds the obstacle [m]: it is all points within it of a convex set, a number
            or an expression; infinity for a half-space.
    """

    kind: str
    distance: Callable[..., Expression]
    figures: tuple[Expression, ...]
    rounding: Expression = 0.0

    def of(self, *points: Expression) -> Expression:
        """Signed distance [m] of a body without thickness: of one point (d, 1), or of the segment between two.

        Args:
            points: the point, or start and end of the segment, (d, 1) [m] each.
        """
        return self._function(points, gradients=False)(*points, *self.figures)

    def with_gradients(self, *points: Expression) -> tuple[Expression, list[Expression]]:
        """The same distance, and its gradient with respect to each of the points (d, 1).

        They take fewer operations than those that CasADi derives, and have no right second derivatives.

        Args:
            points: the point, or start and end of the segment, (d, 1) [m] each.
        """
        found = self._function(points, gradients=True)(*points, *self.figures)
        return found[0], list(found[1:])

    def _function(self, points: Sequence[Expression], *, gradients: bool) -> Function:
        sizes = tuple(each.shape[0] for each in self.figures)
        return _pair_function(self.kind, self.distance, len(points), points[0].shape[0], sizes, gradients)


@cache
def _pair_function(
    kind: str, distance: Callable[..., Any], count: int, size: int, sizes: tuple[int, ...], gradients: bool
) -> Function:
    """(points, figures) -> distance, and with ``gradients`` that of each point."""
    points = [symbol(f"point{i}", size) for i in range(count)]
    figures = [symbol(f"figure{i}", rows) for i, rows in enumerate(sizes)]
    if gradients:
        value, slopes = value_and_gradients(lambda hold: distance(points, *figures, hold=hold), points)
        outputs = [value, *slopes]
    else:
        outputs = [distance(points, *figures)]
    name = f"{kind}_{'segment' if count == 2 else 'point'}{'_gradients' if gradients else ''}"
    made = function(name, [*points, *figures], outputs)
    if made.n_instructions() < LARGE:
        return made
    return function(name, [*points, *figures], outputs, inline=False)
