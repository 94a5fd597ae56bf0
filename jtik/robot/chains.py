"""Joints of common robots: planar arms, Denavit-Hartenberg chains, planar vehicles with an arm."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeAlias, get_args

import numpy as np

from jtik.arguments import array_of, choice, finite_array, flag, integer, several, shape_of
from jtik.errors import ArgumentError
from jtik.robot.dh import JOINT_TYPES, Convention, DHRowLike, as_row, translation
from jtik.robot.joint_type import JointType
from jtik.robot.tree import Joint
from jtik.types import Array

JointBounds: TypeAlias = tuple[object, object, object]
"""Lower limits, upper limits and speed limits: each is one number for all joints, or one number for each joint."""


def planar_joints(links: object, bounds: JointBounds) -> list[Joint]:
    """A planar arm of unit links or given lengths [m] on the frame "base"."""
    return arm_joints("base", _lengths(links), bounds)


def arm_joints(parent: str, lengths: Array, bounds: JointBounds) -> list[Joint]:
    """A planar arm on the frame ``parent``: a revolute joint for each of ``lengths`` (n,) [m], and the tip."""
    limits = _spread(("lower", "upper", "velocity_limit"), bounds, len(lengths))
    joints = []
    offset = 0.0
    for index, length in enumerate(lengths, start=1):
        child = f"link{index}"
        low, high, speed = limits[index - 1]
        joints.append(
            Joint(
                f"joint{index}",
                JointType.REVOLUTE,
                parent,
                child,
                origin=translation(offset, 0, 0),
                lower=low,
                upper=high,
                velocity_limit=speed,
            )
        )
        parent, offset = child, float(length)
    return [*joints, Joint("tip", JointType.FIXED, parent, "tip", origin=translation(offset, 0, 0))]


def vehicle_joints(links: object, heading: bool, arm: JointBounds, carriage: JointBounds) -> list[Joint]:
    """The joints of a planar vehicle and its arm; see `Robot.vehicle`."""
    heading = flag("heading", heading, "whether the vehicle rotates")
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
                JointType.REVOLUTE if name == "heading" else JointType.PRISMATIC,
                frames[index - 1] if index else "base",
                frame,
                axis=np.array(axes[index]),
                lower=low,
                upper=high,
                velocity_limit=speed,
            )
        )
    return [*joints, *arm_joints("vehicle", _lengths(links), arm)]


def dh_joints(rows: Iterable[DHRowLike], convention: Convention, base: object, tool: object) -> list[Joint]:
    """The joints of a Denavit-Hartenberg chain; see `Robot.from_dh`."""
    choice("convention", convention, get_args(Convention))
    before = np.eye(4) if base is None else finite_array("base", base, (4, 4))
    joints = []
    parent = "base"
    accepted = "for each joint a jtik.robot.DHRow, a dict with its fields, or (a, alpha, d, theta)"
    for index, given in enumerate(several("rows", rows, accepted), start=1):
        row = as_row(index, given)
        child = f"link{index}"
        joints.append(
            Joint(
                f"joint{index}",
                JOINT_TYPES[row.joint],
                parent,
                child,
                origin=before @ row.before_joint(convention),
                lower=row.lower,
                upper=row.upper,
                velocity_limit=row.velocity_limit,
            )
        )
        parent, before = child, row.after_joint(convention)
    end = before if tool is None else before @ finite_array("tool", tool, (4, 4))
    return [*joints, Joint("tip", JointType.FIXED, parent, "tip", origin=end)]


def _lengths(links: object) -> Array:
    accepted = "a number of links >= 1, or a sequence of positive lengths [m]"
    if shape_of(links) == ():
        return np.ones(integer("links", links, 1, accepted))
    lengths = array_of("links", links, [(None,)], accepted, lambda x: (x > 0) & np.isfinite(x))
    if lengths.size == 0:
        raise ArgumentError("links", lengths.tolist(), accepted)
    return lengths


def _spread(arguments: tuple[str, str, str], bounds: JointBounds, count: int) -> list[tuple[float, float, float]]:
    """The bounds of each of ``count`` joints."""
    columns = []
    for argument, bound in zip(arguments, bounds, strict=True):
        accepted = f"one number, or {count} numbers, one for each joint"
        values = array_of(argument, bound, [(), (count,)], accepted, lambda x: True)
        columns.append(np.broadcast_to(values, count).tolist())
    return list(zip(*columns, strict=True))
