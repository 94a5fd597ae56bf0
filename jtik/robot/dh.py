"""Denavit-Hartenberg parameters, in both conventions."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any, Literal, TypeAlias, get_args

import numpy as np

from jtik.arguments import choice, finite_array, limits, number, positive_or_infinite
from jtik.constructors import Constructed
from jtik.errors import ArgumentError
from jtik.robot.joint_type import JointType
from jtik.types import Array

Convention: TypeAlias = Literal["standard", "modified"]
DHJoint: TypeAlias = Literal["revolute", "prismatic", "fixed"]

JOINT_TYPES: dict[str, JointType] = {
    "revolute": JointType.REVOLUTE,
    "prismatic": JointType.PRISMATIC,
    "fixed": JointType.FIXED,
}


@dataclass(frozen=True)
class DHRow(metaclass=Constructed):
    """One row of a Denavit-Hartenberg table.

    ``a`` and ``alpha`` belong to link i in the standard convention, and to link i-1 in the modified one (Craig).

    Attributes:
        a: link length [m].
        alpha: link twist [rad].
        d: link offset [m]; of a prismatic joint, the offset at q = 0.
        theta: joint angle [rad]; of a revolute joint, the angle at q = 0.
        joint: "revolute", "prismatic" or "fixed".
        lower: lower limit of q [rad] or [m].
        upper: upper limit of q [rad] or [m].
        velocity_limit: maximum speed [rad/s] or [m/s].

    Raises:
        ArgumentError: when a parameter is not finite or the joint has another type.
    """

    a: float
    alpha: float
    d: float = 0.0
    theta: float = 0.0
    joint: DHJoint = "revolute"
    lower: float = -math.inf
    upper: float = math.inf
    velocity_limit: float = math.inf

    def __post_init__(self) -> None:
        for name in ("a", "alpha", "d", "theta"):
            object.__setattr__(self, name, number(f"DHRow.{name}", getattr(self, name)))
        choice("DHRow.joint", self.joint, get_args(DHJoint))
        for name, value in zip(("lower", "upper"), limits("DHRow limits", self.lower, self.upper), strict=True):
            object.__setattr__(self, name, value)
        speed = positive_or_infinite("DHRow.velocity_limit", self.velocity_limit)
        object.__setattr__(self, "velocity_limit", speed)

    def before_joint(self, convention: Convention) -> Array:
        """The constant part of the row's transform before the motion of the joint, shape (4, 4).

        Args:
            convention: "standard" or "modified".
        """
        offset = rotation_z(self.theta) @ translation(0, 0, self.d)
        if convention == "modified":
            return rotation_x(self.alpha) @ translation(self.a, 0, 0) @ offset
        # Rz(theta) and Tz(d) commute, so the full offset may be applied before either motion.
        return offset

    def after_joint(self, convention: Convention) -> Array:
        """The constant part of the row's transform after the motion of the joint, shape (4, 4).

        Args:
            convention: "standard" or "modified".
        """
        return np.eye(4) if convention == "modified" else translation(self.a, 0, 0) @ rotation_x(self.alpha)


DHRowLike: TypeAlias = DHRow | Mapping[str, Any] | Sequence[float]


def as_row(index: int, row: DHRowLike) -> DHRow:
    """Row number ``index`` (from 1) as a `DHRow`.

    Raises:
        ArgumentError: when it has none of the accepted forms.
    """
    if isinstance(row, DHRow):
        return row
    names = [field.name for field in fields(DHRow)]
    if isinstance(row, Mapping):
        if not {"a", "alpha"} <= set(row) <= set(names):
            raise ArgumentError(f"rows, row {index}", f"keys {list(row)}", f"a and alpha, perhaps {names[2:]}")
        try:
            return DHRow(**row)
        except ArgumentError as error:
            argument = error.argument.replace("DHRow", f"joint 'joint{index}'")
            raise ArgumentError(argument, error.given, error.accepted) from None
    accepted = "a jtik.robot.DHRow, a dict with its fields, or (a, alpha, d, theta)"
    a, alpha, d, theta = finite_array(f"rows, row {index}", row, (4,), accepted).tolist()
    return DHRow(a, alpha, d, theta)


def _rotation(angle: float, first: int, second: int) -> Array:
    pose = np.eye(4)
    pose[first, first] = pose[second, second] = math.cos(angle)
    pose[second, first] = math.sin(angle)
    pose[first, second] = -pose[second, first]
    return pose


def rotation_x(angle: float) -> Array:
    """The rotation by ``angle`` [rad] about x, shape (4, 4)."""
    return _rotation(angle, 1, 2)


def rotation_z(angle: float) -> Array:
    """The rotation by ``angle`` [rad] about z, shape (4, 4)."""
    return _rotation(angle, 0, 1)


def translation(x: float, y: float, z: float) -> Array:
    """The translation by x, y and z [m], shape (4, 4)."""
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose
