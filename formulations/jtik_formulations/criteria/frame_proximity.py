"""A frame near a point, a line, a plane or a height (formulations/frame_proximity.md)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jtik import Criterion, register_criterion
from jtik.arguments import name as read_name
from jtik.arguments import number, several
from jtik.errors import ArgumentError
from jtik.robot import Kinematics, Robot
from jtik.symbolic import Expression, dot, fmax, sqrt, sumsqr
from jtik_formulations.bibliography import KHATIB_1986
from jtik_formulations.criteria._parts.scalars import direction, frame_or_tip, nonzero, vector
from jtik_formulations.criteria._parts.scalars import point as read_point
from jtik_formulations.criteria._parts.shown import shown

SHORTEST_DIRECTION = 1e-9
"""Length of a live direction below which it counts as shorter than 1."""


@register_criterion("frame_proximity")
class FrameProximity(Criterion):
    """H = 1/2 d^2 [m^2], d the distance of a frame's origin to a point, a line, a plane or a height.

    Prefer it to guide an elbow, or any other frame, with the freedom that the task leaves; prefer a second
    `jtik.FrameTask` where the place must be reached. Give exactly one of ``point``, ``line``, ``plane`` and ``height``.

    Live parameters: ``frame_proximity.point`` [m] of a point, line or plane, ``.direction`` of a line or plane, and
    ``.height`` [m] of a height; scale H by ``frame_proximity.weight``.

    Args:
        frame: name of the frame; the tip when None.
        point: a point in the base frame (3,), or (2,) on a planar robot [m].
        line: a point of the line and its direction.
        plane: a point of the plane and its normal; on a planar robot a line with its normal.
        height: the coordinate z, or y on a planar robot, in the base frame [m].
        name: the first part of the names of its parameters.

    Raises:
        ArgumentError: when not exactly one place is given, or a size does not fit the robot, or a direction is zero.
        UnknownNameError: when the robot has no such frame.

    Source: Khatib (1986), an attractive potential.
    """

    name = "frame_proximity"
    summary = "draws a frame to a point, a line, a plane or a height"
    source = "Khatib 1986, the attractive potential"
    bibtex = KHATIB_1986

    def __init__(
        self,
        frame: str | None = None,
        *,
        point: ArrayLike | None = None,
        line: tuple[ArrayLike, ArrayLike] | None = None,
        plane: tuple[ArrayLike, ArrayLike] | None = None,
        height: float | None = None,
        name: str = "frame_proximity",
    ) -> None:
        places: dict[str, Any] = {"point": point, "line": line, "plane": plane, "height": height}
        given = {place: value for place, value in places.items() if value is not None}
        if len(given) != 1:
            raise ArgumentError("place", list(given) or "none", "exactly one of point, line, plane and height")
        self._frame = frame_or_tip(frame)
        ((self._place, value),) = given.items()
        if self._place in ("line", "plane"):
            parts = several(self._place, value, "a pair (point, direction)")
            if len(parts) != 2:
                raise ArgumentError(self._place, value, "a pair (point, direction)")
            first, second = (f"{self._place}[{i}]" for i in range(2))
            self._given: tuple[ArrayLike, ...] = (read_point(first, parts[0]), nonzero(second, parts[1]))
        else:
            self._given = (number("height", value) if self._place == "height" else read_point("point", value),)
        self.name = read_name("name", name)

    @classmethod
    def example(cls, robot: Robot) -> FrameProximity:
        """A plane through the base for the middle one of the moving frames."""
        dimension, frames = robot.dimension, robot.moving_frames
        return cls(frames[len(frames) // 2], plane=(np.zeros(dimension), np.ones(dimension)))

    def __repr__(self) -> str:
        place = [np.asarray(part).tolist() for part in self._given]
        return shown(self, {"frame": self._frame, self._place: place if len(place) > 1 else place[0]}, {})

    def parameters(self, robot: Robot) -> Mapping[str, ArrayLike]:
        """The height, or the point and for a line or plane the direction."""
        robot.frame(self._frame)
        if self._place == "height":
            return {"height": self._given[0]}
        point = vector("point", self._given[0], robot.dimension)
        if self._place == "point":
            return {"point": point}
        return {"point": point, "direction": direction("direction", self._given[1], robot.dimension)}

    def value(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> Expression:
        """Half the squared distance."""
        position = kinematics.position(self._frame)
        if self._place == "height":
            return (position[-1] - parameters["height"]) ** 2 / 2
        away = position - parameters["point"]
        if self._place == "point":
            return sumsqr(away) / 2
        along = parameters["direction"]
        along = along / fmax(sqrt(sumsqr(along)), SHORTEST_DIRECTION)
        if self._place == "plane":
            return dot(along, away) ** 2 / 2
        return sumsqr(away - dot(along, away) * along) / 2
