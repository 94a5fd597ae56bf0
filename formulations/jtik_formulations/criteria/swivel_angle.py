"""The swivel angle: the elbow about the line from shoulder to wrist (formulations/swivel_angle.md)."""

from __future__ import annotations

from collections.abc import Mapping

from numpy.typing import ArrayLike

from jtik import Criterion, register_criterion
from jtik.arguments import name as read_name
from jtik.arguments import number, positive_number
from jtik.errors import ArgumentError
from jtik.robot import Kinematics, Robot
from jtik.symbolic import Expression, cos, cross, dot, fmax, sin, sqrt, sumsqr, vertcat
from jtik_formulations.bibliography import KREUTZ_DELGADO_1992
from jtik_formulations.criteria._parts.scalars import direction
from jtik_formulations.criteria._parts.shown import shown

FLOOR = 0.02
"""Default floor [m]: with a smaller one the curvature near a stretched arm makes first-order strategies slow."""

SMALLEST_FLOOR = 1e-9
"""Smallest floor [m] that is used."""


@register_criterion("swivel_angle")
class SwivelAngle(Criterion):
    """H = 1 - cos(phi - angle), phi the angle of the elbow about the line from shoulder to wrist.

    phi is measured from the direction ``reference``, right-handed about the line: with the default, vertical, 0 is an
    elbow above the line. On a planar robot the default reference is normal to the plane; pi/2 is an elbow on the right
    of the line from shoulder to wrist, -pi/2 one on the left. H has no unit: 0 at the angle, 2 opposite to it. Where
    the elbow is on the line, or the reference along it, phi has no meaning; H fades to 1 there, smoothly, within
    ``floor``. Prefer it to choose the posture of an arm with seven joints, whose elbow turns while the hand is at rest.

    Live parameters: ``swivel_angle.angle`` [rad], ``.reference`` (3,) and ``.floor`` [m].

    Args:
        shoulder: name of the frame of the shoulder.
        elbow: name of the frame of the elbow.
        wrist: name of the frame of the wrist.
        angle: the preferred angle [rad].
        reference: direction (3,) in the base frame at which the angle is 0, of any length but zero.
        floor: distance [m] of the elbow from the line below which H fades.
        name: the first part of the names of its parameters.

    Raises:
        ArgumentError: when the reference is zero, the floor is not positive, or two of the frames are the same.
        UnknownNameError: when the robot has no such frame.

    Source: Kreutz-Delgado, Long and Seraji (1992), the arm angle.
    """

    name = "swivel_angle"
    summary = "turns the elbow about the line from shoulder to wrist"
    source = "Kreutz-Delgado, Long and Seraji 1992"
    bibtex = KREUTZ_DELGADO_1992
    non_negative_parameters = ("floor",)

    def __init__(
        self,
        shoulder: str,
        elbow: str,
        wrist: str,
        *,
        angle: float = 0.0,
        reference: ArrayLike = (0.0, 0.0, 1.0),
        floor: float = FLOOR,
        name: str = "swivel_angle",
    ) -> None:
        frames = {"shoulder": shoulder, "elbow": elbow, "wrist": wrist}
        self._frames = tuple(read_name(each, frame, "the name of a frame") for each, frame in frames.items())
        if len({*self._frames}) < 3:
            raise ArgumentError("shoulder, elbow, wrist", self._frames, "three different frames")
        self._angle = number("angle", angle)
        self._reference = direction("reference", reference, 3)
        self._floor = positive_number("floor", floor)
        self.name = read_name("name", name)

    @classmethod
    def example(cls, robot: Robot) -> SwivelAngle:
        """The base, the middle one of the moving frames and the last, at 1 rad."""
        frames = (robot.base, *robot.moving_frames)
        return cls(frames[0], frames[len(frames) // 2], frames[-1], angle=1.0)

    def __repr__(self) -> str:
        given = dict(zip(("shoulder", "elbow", "wrist"), self._frames, strict=True))
        options = {"angle": self._angle, "reference": self._reference, "floor": self._floor}
        return shown(self, {**given, **options}, {"reference": (0.0, 0.0, 1.0), "floor": FLOOR})

    def parameters(self, robot: Robot) -> Mapping[str, ArrayLike]:
        """The angle, the reference and the floor."""
        for frame in self._frames:
            robot.frame(frame)
        return {"angle": self._angle, "reference": self._reference, "floor": self._floor}

    def value(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> Expression:
        """1 - cos of the deviation from the preferred angle."""
        a, b, floor = self.coordinates(kinematics, parameters)
        wanted = a * cos(parameters["angle"]) + b * sin(parameters["angle"])
        return 1 - wanted / sqrt(a**2 + b**2 + floor**2)

    def coordinates(
        self, kinematics: Kinematics, parameters: Mapping[str, Expression]
    ) -> tuple[Expression, Expression, Expression]:
        """The elbow's coordinates [m] across the line, along the reference and along line x reference; the floor."""
        shoulder, elbow, wrist = (_in_space(kinematics.position(frame)) for frame in self._frames)
        floor = fmax(parameters["floor"], SMALLEST_FLOOR)
        reference = parameters["reference"]
        reference = reference / fmax(sqrt(sumsqr(reference)), SMALLEST_FLOOR)
        line, arm = wrist - shoulder, elbow - shoulder
        squared = sumsqr(line) + floor**2
        x = reference - dot(reference, line) / squared * line
        across = arm - dot(arm, line) / squared * line
        return dot(across, x), dot(across, cross(line, x)) / sqrt(squared), floor


def _in_space(position: Expression) -> Expression:
    """The position (3, 1), with z = 0 on a planar robot."""
    return position if position.shape[0] == 3 else vertcat(position, 0)
