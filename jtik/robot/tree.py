"""Joints as data, and the checks that a list of joints is a tree."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from functools import partial
from typing import Any

import numpy as np

from jtik.arguments import finite_array, limits, number, positive_or_infinite, text
from jtik.constructors import Constructed
from jtik.errors import ArgumentError, UnknownNameError
from jtik.robot.joint_type import JointType
from jtik.types import Array

UNIT_TOLERANCE = 1e-9
"""Tolerance on the length of an axis and on the orthonormality of a rotation: it admits rounding errors only."""


def frozen(array: Array) -> Array:
    """``array`` itself, made read-only."""
    array.flags.writeable = False
    return array


@dataclass(frozen=True)
class Mimic(metaclass=Constructed):
    """A joint that follows another one: its position is ``multiplier * position(joint) + offset``.

    Attributes:
        joint: name of the joint that is followed; a revolute or prismatic joint that does not follow another itself.
        multiplier: ratio of the positions; not zero.
        offset: position [rad] or [m] when the other joint is at zero.
    """

    joint: str
    multiplier: float = 1.0
    offset: float = 0.0

    def __post_init__(self) -> None:
        text("Mimic.joint", self.joint, "the name of a joint")
        object.__setattr__(self, "offset", number("Mimic.offset", self.offset))
        object.__setattr__(self, "multiplier", number("Mimic.multiplier", self.multiplier))
        if self.multiplier == 0.0:
            raise ArgumentError("Mimic.multiplier", self.multiplier, "a non-zero number")


@dataclass(frozen=True, eq=False)
class Joint(metaclass=Constructed):
    """One joint and the frame it carries: T_parent_child(q) = origin . motion(q).

    Attributes:
        name: unique among the joints.
        type: see `JointType`.
        parent: name of the frame that carries the joint.
        child: name of the frame it moves; unique among the frames.
        origin: pose of the joint in the parent frame, (4, 4) [m]; the identity by default.
        axis: unit vector (3,) in the joint's frame, of a revolute or prismatic joint; z by default.
        lower: lower limit [rad] or [m] of a revolute or prismatic joint; -inf when there is none.
        upper: upper limit [rad] or [m] of a revolute or prismatic joint; inf when there is none.
        velocity_limit: maximum speed of each velocity entry [rad/s] or [m/s]; inf when there is none.
        effort_limit: maximum torque [N m] or force [N] of each velocity entry; inf when it is not known.
        mimic: the joint that it follows, for a revolute or prismatic joint without a position of its own.

    Raises:
        ArgumentError: when a value cannot be used; the message names the joint.
    """

    name: str
    type: JointType
    parent: str
    child: str
    origin: Array = field(default_factory=lambda: np.eye(4), kw_only=True)
    axis: Array = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]), kw_only=True)
    lower: float = field(default=-math.inf, kw_only=True)
    upper: float = field(default=math.inf, kw_only=True)
    velocity_limit: float = field(default=math.inf, kw_only=True)
    effort_limit: float = field(default=math.inf, kw_only=True)
    mimic: Mimic | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        who = f"joint {text('Joint.name', self.name)!r}"
        for attribute in ("parent", "child"):
            text(f"{who} {attribute}", getattr(self, attribute), "the name of a frame")
        if self.mimic is not None and not isinstance(self.mimic, Mimic):
            raise ArgumentError(f"{who} mimic", repr(self.mimic), "a jtik.robot.Mimic, such as Mimic('elbow'), or None")
        if not isinstance(self.type, JointType):
            raise ArgumentError(f"{who} type", self.type, ", ".join(str(kind) for kind in JointType))
        object.__setattr__(self, "origin", frozen(_pose(f"{who} origin", self.origin)))
        object.__setattr__(self, "axis", frozen(_unit(f"{who} axis", self.axis)))
        lower, upper = limits(f"{who} limits", self.lower, self.upper)
        speed = positive_or_infinite(f"{who} velocity_limit", self.velocity_limit, "a positive number or inf")
        effort = positive_or_infinite(f"{who} effort_limit", self.effort_limit, "a positive number or inf")
        values = {"lower": lower, "upper": upper, "velocity_limit": speed, "effort_limit": effort}
        for attribute, value in values.items():
            object.__setattr__(self, attribute, value)
        if not self.type.is_scalar:
            if math.isfinite(lower) or math.isfinite(upper):
                given = f"lower {lower:g}, upper {upper:g} on a {self.type.value} joint"
                raise ArgumentError(f"{who} limits", given, "limits on revolute and prismatic joints only")
            if self.mimic is not None:
                raise ArgumentError(f"{who} mimic", f"a {self.type.value} joint", "a revolute or prismatic joint")

    def __reduce__(self) -> tuple[Any, ...]:
        # Rebuilt by the constructor: the arrays in a copy of the state would not be read-only.
        return partial(type(self), **{f.name: getattr(self, f.name) for f in fields(self)}), ()

    @property
    def is_moving(self) -> bool:
        """Whether it can move: True for every type but a fixed joint."""
        return self.type is not JointType.FIXED

    @property
    def is_independent(self) -> bool:
        """Whether it has a position of its own in q: it moves and follows no other joint."""
        return self.is_moving and self.mimic is None


def _pose(argument: str, value: object) -> Array:
    pose = finite_array(argument, value, (4, 4))
    rotation = pose[:3, :3]
    error = float(np.abs(rotation @ rotation.T - np.eye(3)).max())
    volume = float(np.linalg.det(rotation))
    if error > UNIT_TOLERANCE or volume < 0:
        raise ArgumentError(
            argument,
            f"a rotation part off orthonormal by {error:.3g}, of determinant {volume:.3g}",
            "a right-handed rotation and a translation",
        )
    if not np.array_equal(pose[3], [0.0, 0.0, 0.0, 1.0]):
        raise ArgumentError(argument, f"last row {pose[3].tolist()}", "last row [0, 0, 0, 1]")
    return pose


def _unit(argument: str, value: object) -> Array:
    axis = finite_array(argument, value, (3,))
    length = float(np.linalg.norm(axis))
    if abs(length - 1.0) > UNIT_TOLERANCE:
        raise ArgumentError(argument, f"{axis.tolist()} of length {length:g}", "a vector of length 1")
    return axis / length


def check_tree(joints: Sequence[Joint], base: str) -> None:
    """Check that the joints form a tree on the frame ``base``.

    Raises:
        ArgumentError: on duplicate names or a cycle.
        UnknownNameError: when a parent frame or a mimicked joint does not exist.
    """
    _check_unique("joint name", [joint.name for joint in joints])
    _check_unique("frame name", [base, *(joint.child for joint in joints)])
    parent_of = {joint.child: joint.parent for joint in joints}
    for joint in joints:
        if joint.parent != base and joint.parent not in parent_of:
            raise UnknownNameError(f"parent frame of joint {joint.name!r}", joint.parent, [base, *parent_of])
    connected = {base}
    for frame in parent_of:
        path = [frame]
        while path[-1] not in connected:
            above = parent_of[path[-1]]
            if above in path:
                raise ArgumentError("joints", f"a cycle {' -> '.join([*path, above])}", f"a tree on {base!r}")
            path.append(above)
        connected.update(path)
    leaders = {joint.name: joint for joint in joints if joint.is_independent and joint.type.is_scalar}
    for joint in joints:
        if joint.mimic is not None and joint.mimic.joint not in leaders:
            raise UnknownNameError(f"joint for {joint.name!r} to mimic", joint.mimic.joint, leaders)


def check_moves(joints: Sequence[Joint]) -> None:
    """Check that at least one joint moves.

    Raises:
        ArgumentError: when no joint moves by itself.
    """
    if not any(joint.is_independent for joint in joints):
        raise ArgumentError("joints", f"{len(joints)} joints, none of which moves", "at least one moving joint")


def check_planar(joints: Sequence[Joint]) -> None:
    """Check that the joints keep every frame in the x-y plane.

    Raises:
        ArgumentError: naming the first joint that leaves the plane.
    """
    for joint in joints:
        along = abs(float(joint.axis[2]))
        stays = {
            JointType.FIXED: True,
            JointType.REVOLUTE: abs(along - 1.0) <= UNIT_TOLERANCE,
            JointType.PRISMATIC: along <= UNIT_TOLERANCE,
        }.get(joint.type, False)
        level = abs(abs(joint.origin[2, 2]) - 1.0) <= UNIT_TOLERANCE and joint.origin[2, 3] == 0.0
        if not (stays and level):
            raise ArgumentError(
                "planar",
                f"True, but joint {joint.name!r} leaves the x-y plane",
                "revolute joints about z and prismatic joints in the plane, with origins in the plane",
            )


def _check_unique(what: str, names: Sequence[str]) -> None:
    repeated = sorted(name for name, count in Counter(names).items() if count > 1)
    if repeated:
        raise ArgumentError("joints", f"{what} {repeated[0]!r} more than once", f"each {what} once")
