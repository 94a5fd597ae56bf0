"""Distances of a body to obstacles as functions that are built once, and called for every body."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, TypeAlias

from jtik.symbolic import Expression, Function, function, horzcat, symbol, vertcat
from jtik.symbolic.held import value_and_gradients

LARGE = 1000
"""Instructions above which a function is called in an expression rather than copied into it.

A call takes as long as some 200 instructions, and building an expression takes time in proportion to its size.
"""

SHARED = 5 * LARGE
"""Instructions up to which what the distances of a body share is searched for; of larger ones it is a small part."""

Form: TypeAlias = tuple[str, Callable[..., Any], tuple[int, ...]]
"""The kind of an obstacle, its distance, and the sizes of its figures."""


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
        return distances_of(points, [self])

    @property
    def form(self) -> Form:
        """What a function of the distance depends on."""
        return self.kind, self.distance, tuple(each.shape[0] for each in self.figures)


def distances_of(points: Sequence[Expression], obstacles: Sequence[Distances]) -> Expression:
    """Signed distances [m] of a body without thickness to several obstacles, (1, obstacles).

    Args:
        points: one point (d, 1) [m], or start and end of a segment.
        obstacles: the obstacles.
    """
    return _function(points, obstacles, gradients=False)(*points, figures_of(obstacles))


def distances_with_gradients(
    points: Sequence[Expression], obstacles: Sequence[Distances]
) -> tuple[Expression, list[Expression]]:
    """The same distances, and for each of the points their gradients with respect to it (d, obstacles).

    They take fewer operations than those that CasADi derives, and have no right second derivatives.

    Args:
        points: one point (d, 1) [m], or start and end of a segment.
        obstacles: the obstacles.
    """
    found = _function(points, obstacles, gradients=True)(*points, figures_of(obstacles))
    return found[0], list(found[1:])


def figures_of(obstacles: Sequence[Distances]) -> Expression:
    """What the distances to several obstacles are computed from, a column."""
    return vertcat(*(each for obstacle in obstacles for each in obstacle.figures))


def _function(points: Sequence[Expression], obstacles: Sequence[Distances], *, gradients: bool) -> Function:
    return _of_several(tuple(each.form for each in obstacles), len(points), points[0].shape[0], gradients)


@cache
def _of_several(forms: tuple[Form, ...], count: int, size: int, gradients: bool) -> Function:
    """(points, all figures) -> distances, and with ``gradients`` those of each point."""
    points = [symbol(f"point{i}", size) for i in range(count)]
    columns = [[symbol(f"figure{i}", rows) for i, rows in enumerate(sizes)] for _, _, sizes in forms]
    found, instructions = [], 0
    for form, own in zip(forms, columns, strict=True):
        one = distance_function(form, count, size, gradients=gradients)
        instructions += one.n_instructions()
        found.append(one.call([*points, *own]))
    figures = vertcat(*(each for own in columns for each in own))
    inputs, outputs = [*points, figures], [horzcat(*each) for each in zip(*found, strict=True)]
    name = f"{forms[0][0]}_{'segment' if count == 2 else 'point'}{'_gradients' if gradients else ''}"
    return function(name, inputs, outputs, inline=instructions <= LARGE, cse=instructions <= SHARED)


@cache
def distance_function(form: Form, count: int, size: int, *, gradients: bool) -> Function:
    """(points, figures) -> distance, and with ``gradients`` its gradient with respect to each point.

    Args:
        form: the kind of the obstacle.
        count: number of points of the body: 1, or 2 of a segment.
        size: entries of a point.
        gradients: whether there are gradients.
    """
    _, distance, sizes = form
    points = [symbol(f"point{i}", size) for i in range(count)]
    figures = [symbol(f"figure{i}", rows) for i, rows in enumerate(sizes)]
    if gradients:
        value, derivatives = value_and_gradients(lambda hold: distance(points, *figures, hold=hold), points)
        return function("gradients", [*points, *figures], [value, *derivatives])
    return function("distance", [*points, *figures], [distance(points, *figures)])
