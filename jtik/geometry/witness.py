"""The closest points of a body and an obstacle, and the normal between them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from jtik.arguments import finite_array, non_negative_number
from jtik.errors import ArgumentError
from jtik.geometry.kinds import KINDS
from jtik.geometry.slots import ACCEPTED
from jtik.geometry.solids import Solid
from jtik.symbolic import dot, function, is_symbolic, ratio, symbol, vertcat
from jtik.symbolic.held import value_and_gradients


class Witness(NamedTuple):
    """Where a body and an obstacle are closest to each other, or where they penetrate deepest.

    Expressions where a point of the body is one, else numbers and arrays (d,).

    Attributes:
        distance: signed distance [m]; negative where they overlap.
        on_body: the point of the body's surface (d, 1) [m].
        on_obstacle: the point of the obstacle's surface, ``distance`` away.
        normal: the unit vector from the obstacle to the body, along which a translation of the body increases the
            distance as fast as it moves.
    """

    distance: Any
    on_body: Any
    on_obstacle: Any
    normal: Any


def witness(obstacle: Solid, *points: Any, radius: float = 0.0) -> Witness:
    """The closest points of an obstacle and a point, or a segment between two points, with a radius.

    They follow from the signed distance: its gradient for a translation is the normal, and the parts of both ends of a
    segment in it say where on the segment the closest point is. Where several pairs of points are as close it is one of
    them or between them, and where a segment crosses the axis of a capsule in space the normal is zero.

    Args:
        obstacle: the obstacle.
        points: one or two points (d,) [m], numbers or expressions (d, 1).
        radius: radius of the body around them [m].

    Raises:
        ArgumentError: for an obstacle that is none, another number or shape of points, or a negative radius.
    """
    kind = next((kind for kind in KINDS if isinstance(obstacle, kind.solid)), None)
    if kind is None:
        raise ArgumentError("obstacle", obstacle, " or ".join(ACCEPTED.values()))
    if len(points) not in (1, 2):
        raise ArgumentError("points", f"{len(points)} points", "one point, or the two ends of a segment")
    size, thickness = obstacle.dimension, non_negative_number("radius", radius, "a non-negative length [m]")
    ends = [_point(f"points[{i}]", each, size) for i, each in enumerate(points)]
    symbols = [symbol(f"point{i}", size) for i in range(len(ends))]
    rows = [vertcat(*np.ravel(each).tolist()) for each in kind.numbers(obstacle)]
    figures = kind.figures(*rows)
    distance, gradients = value_and_gradients(lambda hold: kind.distance(symbols, *figures, hold=hold), symbols)
    normal = sum(gradients[1:], start=gradients[0])
    place = symbols[0]
    if len(symbols) == 2:
        place = place + ratio(dot(gradients[1], normal), dot(normal, normal)) * (symbols[1] - symbols[0])
    outputs = [distance - thickness, place - thickness * normal, place - distance * normal, normal]
    found = function("witness", symbols, outputs)(*ends)
    if any(is_symbolic(each) for each in ends):
        return Witness(*found)
    return Witness(float(found[0]), *(each.full()[:, 0] for each in found[1:]))


def _point(argument: str, point: Any, size: int) -> Any:
    """A point as an expression (d, 1) or an array (d,). Raises ArgumentError for another shape."""
    if not is_symbolic(point):
        return finite_array(argument, point, (size,))
    if point.shape != (size, 1):
        raise ArgumentError(argument, f"an expression of shape {point.shape}", f"shape ({size}, 1)")
    return point
