"""The centre of mass above a support polygon, softly (formulations/support_polygon.md)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from jtik import Criterion, register_criterion
from jtik.arguments import array_of, positive_number
from jtik.arguments import name as read_name
from jtik.errors import ArgumentError
from jtik.robot import Kinematics, Robot
from jtik.symbolic import Expression, fmax, if_else, sqrt
from jtik.types import Array
from jtik_formulations.bibliography import MCGHEE_FRANK_1968
from jtik_formulations.criteria._parts.scalars import frame_or_tip
from jtik_formulations.criteria._parts.shown import shown

MARGIN = 0.02
"""Default of the margin [m]."""

SMALLEST = 1e-9
"""Length of a live edge [m] that counts as none."""

SMALLEST_MARGIN = 1e-3
"""Smallest margin [m] that is used: H is curved by its square."""


@register_criterion("support_polygon")
class SupportPolygon(Criterion):
    """H = sum over the edges of phi(1 - d_i / margin), no unit, d_i the distance of the centre of mass inside the edge.

    phi(x) is zero for x <= 0, 1/6 on the edge and quadratic outside, with a continuous second derivative: H is zero
    where the centre of mass is above the polygon and ``margin`` away from its edges. Prefer it to keep a legged robot,
    or an arm on a vehicle, from tipping over where other criteria may ask for more; prefer a `jtik.CenterOfMassTask`
    where the place of the centre of mass must be reached. It is a cost, and no guarantee.

    Live parameters: ``support_polygon.vertices`` (k, 2) [m] and ``support_polygon.margin`` [m]. A repeated vertex
    counts once, so that a polygon can lose corners while a program runs; live vertices must stay convex.

    Args:
        vertices: corners (k, 2) [m] of a convex polygon, in order, in the x-y plane of ``frame``.
        margin: positive distance from the edges [m] at which the cost begins; at least 1 mm is used.
        frame: name of the frame that carries the polygon, such as that of a vehicle; the base when None.
        name: the first part of the names of its parameters.

    Raises:
        ArgumentError: when the polygon has fewer than three corners, no area or is not convex, the margin is not
            positive, or the robot has no masses.
        UnknownNameError: when the robot has no such frame.

    Source: McGhee and Frank (1968), the static stability margin.
    """

    name = "support_polygon"
    summary = "keeps the centre of mass above a polygon"
    source = "McGhee and Frank 1968, the margin"
    bibtex = MCGHEE_FRANK_1968
    non_negative_parameters = ("margin",)

    def __init__(
        self,
        vertices: ArrayLike,
        *,
        margin: float = MARGIN,
        frame: str | None = None,
        name: str = "support_polygon",
    ) -> None:
        self._vertices = _convex("vertices", vertices)
        self._margin = positive_number("margin", margin, "a positive distance [m]")
        self._frame = frame_or_tip(frame)
        self.name = read_name("name", name)

    @classmethod
    def example(cls, robot: Robot) -> SupportPolygon:
        """A triangle about the base."""
        return cls([(0.3, 0.0), (-0.1, 0.2), (-0.1, -0.2)])

    def __repr__(self) -> str:
        given = {"vertices": self._vertices.tolist(), "margin": self._margin, "frame": self._frame}
        return shown(self, given, {"margin": MARGIN})

    def parameters(self, robot: Robot) -> Mapping[str, ArrayLike]:
        """The corners (k, 2) and the margin."""
        if not robot.masses:
            raise ArgumentError("robot", repr(robot), "a robot with masses; Robot.with_masses adds them")
        if self._frame is not None:
            robot.frame(self._frame)
        return {"vertices": self._vertices, "margin": self._margin}

    def accepted_instead(self, parameter: str, value: Array) -> str | None:
        """The corners are those of a convex polygon; one that is repeated counts once."""
        try:
            if parameter == "vertices":
                _convex(parameter, value[(value != np.roll(value, -1, axis=0)).any(axis=1)])
        except ArgumentError as error:
            return error.accepted
        return None

    def value(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> Expression:
        """The sum of phi(1 - d_i / margin)."""
        margin, corners = fmax(parameters["margin"], SMALLEST_MARGIN), parameters["vertices"]
        rows = [(corners[i, 0], corners[i, 1]) for i in range(self._vertices.shape[0])]
        edges = list(zip(rows, [*rows[1:], rows[0]], strict=True))
        twice_area = sum(ax * by - bx * ay for (ax, ay), (bx, by) in edges)
        x, y = self._ground_point(kinematics)
        total: Expression = 0
        for (ax, ay), (bx, by) in edges:
            ex, ey = bx - ax, by - ay
            length = sqrt(fmax(ex**2 + ey**2, SMALLEST**2))
            inside = if_else(twice_area < 0, -1, 1) * (ex * (y - ay) - ey * (x - ax)) / length
            beyond = fmax(1 - inside / margin, 0)
            phi = if_else(beyond < 1, beyond**3 / 6, (beyond**2 - beyond) / 2 + 1 / 6)
            total += if_else(length > SMALLEST, phi, 0)
        return total

    def _ground_point(self, kinematics: Kinematics) -> tuple[Expression, Expression]:
        """The first two coordinates of the centre of mass in the frame of the polygon."""
        center = kinematics.center_of_mass()
        if self._frame is None:
            return center[0], center[1]
        axes = kinematics.rotation(self._frame)
        away = center - kinematics.position(self._frame)
        axes = axes[: kinematics.robot.dimension, :2]
        along = axes.T @ away
        return along[0], along[1]


def _convex(argument: str, given: ArrayLike) -> Array:
    """The corners. Raises ArgumentError unless they are a convex polygon with an area, in either order."""
    accepted = "at least three corners (k, 2) [m] of a convex polygon, in order"
    corners = array_of(argument, given, [(None, 2)], accepted)
    edges = np.roll(corners, -1, axis=0) - corners
    if len(corners) < 3 or not np.all(np.linalg.norm(edges, axis=1) > SMALLEST):
        raise ArgumentError(argument, given, f"{accepted}, each once")
    ahead = np.roll(edges, -1, axis=0)
    turns = edges[:, 0] * ahead[:, 1] - edges[:, 1] * ahead[:, 0]
    angles = np.arctan2(turns, np.sum(edges * ahead, axis=1))
    # a star turns to one side only, and goes round twice
    one_side = np.all(turns >= 0) or np.all(turns <= 0)
    if not one_side or abs(abs(angles.sum()) - 2 * np.pi) > 1e-6:
        raise ArgumentError(argument, given, accepted)
    return corners
