"""Builders of common robots: planar arms, Denavit-Hartenberg chains, planar vehicles with an arm."""

from __future__ import annotations

import math
import operator
from collections.abc import Iterable
from typing import TYPE_CHECKING, TypeAlias, get_args, overload

import numpy as np

from jtik.errors import ArgumentError, Array, finite_array
from jtik.robot.dh import JOINT_TYPES, Convention, Row, as_row, shift
from jtik.robot.joints import JointType
from jtik.robot.tree import Joint

if TYPE_CHECKING:
    from jtik.robot.model import Robot

Bounds: TypeAlias = tuple[object, object, object]
"""Lower limits, upper limits and speed limits, each one number for all joints or one for each."""


class PlanarBuilder:
    """``Robot.planar``, asked of the class: builds a planar arm."""

    def __init__(self, owner: type[Robot]) -> None:
        self._owner = owner

    def __call__(
        self,
        links: object,
        *,
        lower: object = -math.inf,
        upper: object = math.inf,
        velocity_limit: object = math.inf,
        name: str | None = None,
    ) -> Robot:
        """A planar arm of hinges "joint1" ... at frames "link1" ..., ending in the frame "tip".

        At q = 0 it lies stretched along x. Positions are (x, y).

        Args:
            links: number of unit links, or their lengths [m].
            lower: lower limits [rad], one for all joints or one each.
            upper: upper limits [rad].
            velocity_limit: greatest speeds [rad/s].
            name: what to call the robot.

        Raises:
            ArgumentError: when a length is not positive or limits are crossed.
        """
        joints = arm_joints("base", _lengths(links), (lower, upper, velocity_limit))
        return self._owner(joints, name=name or f"planar{len(joints) - 1}", planar=True)


class PlanarAttribute:
    """``planar``: of the class `Robot` the builder of planar arms, of a robot whether it is planar.

    Both names belong to the public surface; a descriptor lets each be what its reader expects.
    """

    @overload
    def __get__(self, robot: None, owner: type[Robot]) -> PlanarBuilder: ...

    @overload
    def __get__(self, robot: Robot, owner: type[Robot]) -> bool: ...

    def __get__(self, robot: Robot | None, owner: type[Robot]) -> PlanarBuilder | bool:
        return PlanarBuilder(owner) if robot is None else robot.dimension == 2


def arm_joints(parent: str, lengths: Array, bounds: Bounds) -> list[Joint]:
    """A planar arm on the frame ``parent``: a hinge for each of ``lengths`` (n,) [m], and the tip."""
    limits = _spread(("lower", "upper", "velocity_limit"), bounds, len(lengths))
    joints = []
    reach = 0.0
    for index, length in enumerate(lengths, start=1):
        child = f"link{index}"
        low, high, speed = limits[index - 1]
        joints.append(
            Joint(
                f"joint{index}",
                JointType.HINGE,
                parent,
                child,
                origin=shift(reach, 0, 0),
                lower=low,
                upper=high,
                velocity_limit=speed,
            )
        )
        parent, reach = child, float(length)
    return [*joints, Joint("tip", JointType.FIXED, parent, "tip", origin=shift(reach, 0, 0))]


def vehicle_joints(links: object, heading: bool, arm: Bounds, carriage: Bounds) -> list[Joint]:
    """The joints of a planar vehicle and its arm; see `Robot.vehicle`."""
    names = ["x", "y", "heading"] if heading else ["x", "y"]
    frames = ["slide_x", "slide_y", "vehicle"] if heading else ["slide_x", "vehicle"]
    axes = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0])
    arguments = ("vehicle_lower", "vehicle_upper", "vehicle_velocity_limit")
    limits = _spread(arguments, carriage, len(names))
    joints = []
    for index, (name, frame) in enumerate(zip(names, frames, strict=True)):
        low, high, speed = limits[index]
        joints.append(
            Joint(
                name,
                JointType.HINGE if name == "heading" else JointType.SLIDE,
                frames[index - 1] if index else "base",
                frame,
                axis=np.array(axes[index]),
                lower=low,
                upper=high,
                velocity_limit=speed,
            )
        )
    return [*joints, *arm_joints("vehicle", _lengths(links), arm)]


def dh_joints(rows: Iterable[Row], convention: Convention, base: object, tool: object) -> list[Joint]:
    """The joints of a Denavit-Hartenberg chain; see `Robot.from_dh`."""
    if convention not in get_args(Convention):
        raise ArgumentError("convention", convention, " or ".join(repr(c) for c in get_args(Convention)))
    ahead = np.eye(4) if base is None else finite_array("base", base, (4, 4))
    joints = []
    parent = "base"
    for index, given in enumerate(rows, start=1):
        row = as_row(index, given)
        child = f"link{index}"
        joints.append(
            Joint(
                f"joint{index}",
                JOINT_TYPES[row.joint],
                parent,
                child,
                origin=ahead @ row.before_joint(convention),
                lower=row.lower,
                upper=row.upper,
                velocity_limit=row.velocity_limit,
            )
        )
        parent, ahead = child, row.after_joint(convention)
    end = ahead if tool is None else ahead @ finite_array("tool", tool, (4, 4))
    return [*joints, Joint("tip", JointType.FIXED, parent, "tip", origin=end)]


def _lengths(links: object) -> Array:
    accepted = "a number of links >= 1, or a sequence of positive lengths [m]"
    if np.ndim(links) == 0:  # type: ignore[arg-type]
        try:
            count = operator.index(links)  # type: ignore[arg-type]
        except TypeError as error:
            raise ArgumentError("links", links, accepted) from error
        if count < 1:
            raise ArgumentError("links", links, accepted)
        return np.ones(count)
    lengths = finite_array("links", links, (None,))
    if lengths.size == 0 or lengths.min() <= 0:
        raise ArgumentError("links", lengths.tolist(), accepted)
    return lengths


def _spread(arguments: tuple[str, str, str], bounds: Bounds, count: int) -> list[tuple[float, float, float]]:
    """The bounds of each of ``count`` joints."""
    columns = []
    for argument, bound in zip(arguments, bounds, strict=True):
        values = np.asarray(bound)
        if values.dtype.kind not in "fiub" or values.shape not in ((), (count,)):
            raise ArgumentError(argument, bound, f"one number, or {count} numbers, one for each joint")
        columns.append(np.broadcast_to(values, count).tolist())
    return list(zip(*columns, strict=True))
