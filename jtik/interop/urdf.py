"""A robot as URDF text, for libraries that read URDF only: joints, limits and masses, without solids and meshes."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from jtik.arguments import instance, positive_number
from jtik.errors import ArgumentError
from jtik.robot import Joint, JointType, Robot
from jtik.robot.masses_and_shapes import Mass
from jtik.types import Array

UNLIMITED = 1e6
"""Limit [rad] or [m], and speed [rad/s] or [m/s], of a joint without one where URDF needs a number."""

MINIMUM_RANGE = 1e-9
"""Range [rad] or [m] of a joint whose limits are equal: readers ignore limits that are both zero."""


def to_urdf(
    robot: Robot, *, revolute_limit: float | None = None, frame: str | None = None, turn: float | None = None
) -> str:
    """The robot as URDF; every frame becomes a link, and every joint a joint, with the same name.

    A fixed joint with the name of a frame gets the suffix " (fixed)", since Pinocchio has both in one list. A revolute
    joint without limits becomes "continuous"; other infinite limits become `UNLIMITED`. A planar robot lies in the x-y
    plane of space.

    Args:
        robot: the robot, with revolute, prismatic and fixed joints.
        revolute_limit: limits of revolute joints that have none, -revolute_limit and revolute_limit [rad], for
            libraries that need limits; None leaves such joints without limits.
        frame: write only the chain from the base to this frame; None for the full robot.
        turn: deprecated name of ``revolute_limit``.

    Raises:
        ArgumentError: for a ball or free joint, which URDF cannot describe, or a limit that is not positive.
        UnknownNameError: when there is no such frame.
    """
    if turn is not None:
        warnings.warn("to_urdf(turn=) is now to_urdf(revolute_limit=)", DeprecationWarning, stacklevel=2)
        revolute_limit = turn
    instance("robot", robot, Robot, "a jtik.Robot")
    if revolute_limit is not None:
        revolute_limit = positive_number("revolute_limit", revolute_limit, "a positive angle [rad], or None")
    joints = robot.joints if frame is None else _chain(robot, frame)
    frames = [robot.base, *(joint.child for joint in joints)]
    root = Element("robot", name=robot.name)
    # otherwise MuJoCo merges links that are fixed to each other
    SubElement(SubElement(root, "mujoco"), "compiler", fusestatic="false")
    for link in frames:
        element = SubElement(root, "link", name=link)
        if link in robot.masses:
            _add_mass(element, robot.masses[link])
    for joint in joints:
        _add_joint(root, joint, revolute_limit, frames)
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode")


def _chain(robot: Robot, frame: str) -> Iterable[Joint]:
    """The joints before a frame; raises ArgumentError when one of them follows a joint that is not among them."""
    joints = robot.path(frame)
    names = {joint.name for joint in joints}
    for joint in joints:
        if joint.mimic is not None and joint.mimic.joint not in names:
            given = f"{frame!r}, whose joint {joint.name!r} follows {joint.mimic.joint!r} elsewhere"
            raise ArgumentError("frame", given, "a frame whose joints depend on no others, or None for all")
    return joints


def _add_joint(root: Element, joint: Joint, limit: float | None, frames: list[str]) -> None:
    unlimited = math.isinf(joint.lower) and math.isinf(joint.upper)
    kinds = {JointType.FIXED: "fixed", JointType.PRISMATIC: "prismatic", JointType.REVOLUTE: "revolute"}
    if joint.type not in kinds:
        given = f"a {joint.type.value} joint {joint.name!r}"
        raise ArgumentError("robot", given, "revolute, prismatic and fixed joints")
    kind = kinds[joint.type]
    if joint.type is JointType.REVOLUTE and unlimited and limit is None:
        kind = "continuous"
    name = f"{joint.name} (fixed)" if not joint.is_moving and joint.name in frames else joint.name
    element = SubElement(root, "joint", name=name, type=kind)
    SubElement(element, "origin", xyz=_words(joint.origin[:3, 3]), rpy=_words(_angles(joint.origin[:3, :3])))
    SubElement(element, "parent", link=joint.parent)
    SubElement(element, "child", link=joint.child)
    if not joint.is_moving:
        return
    SubElement(element, "axis", xyz=_words(joint.axis))
    speed = _word(min(joint.velocity_limit, UNLIMITED))
    effort = _word(joint.effort_limit) if math.isfinite(joint.effort_limit) else "0"
    if kind == "continuous":
        SubElement(element, "limit", effort=effort, velocity=speed)
    else:
        bound = limit if unlimited and limit is not None and joint.type is JointType.REVOLUTE else UNLIMITED
        low, high = max(joint.lower, -bound), min(joint.upper, bound)
        bounds = {"lower": _word(low), "upper": _word(max(high, low + MINIMUM_RANGE))}
        SubElement(element, "limit", bounds, effort=effort, velocity=speed)
    if joint.mimic is not None:
        follow = joint.mimic
        ratio = {"multiplier": _word(follow.multiplier), "offset": _word(follow.offset)}
        SubElement(element, "mimic", ratio, joint=follow.joint)


def _add_mass(link: Element, mass: Mass) -> None:
    """The mass, its centre and its inertia in the axes of the link."""
    inertial = SubElement(link, "inertial")
    SubElement(inertial, "origin", xyz=_words(np.asarray(mass.center, dtype=float)), rpy="0 0 0")
    SubElement(inertial, "mass", value=_word(mass.mass))
    moments = {f"i{'xyz'[i]}{'xyz'[j]}": _word(mass.inertia[i, j]) for i in range(3) for j in range(i, 3)}
    SubElement(inertial, "inertia", moments)


def _angles(R: Array) -> Array:
    """Roll, pitch and yaw [rad] about fixed axes: R = Rz(yaw) Ry(pitch) Rx(roll)."""
    yaw = math.atan2(R[1, 0], R[0, 0])
    c, s = math.cos(yaw), math.sin(yaw)
    pitch = math.atan2(-R[2, 0], c * R[0, 0] + s * R[1, 0])
    # from the rotation after the yaw: at a pitch near a right angle the yaw is a rounding error, which the roll matches
    roll = math.atan2(s * R[0, 2] - c * R[1, 2], c * R[1, 1] - s * R[0, 1])
    return np.array([roll, pitch, yaw])


def _words(values: Array) -> str:
    return " ".join(_word(value) for value in values)


def _word(value: float) -> str:
    """The shortest text that reads back as the same number."""
    return repr(float(value) + 0.0)  # no -0.0


__all__ = ["UNLIMITED", "to_urdf"]
