"""Rigid bodies: the masses on frames that move as one, merged in numbers, and the joints that move none."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from jtik.robot.masses_and_shapes import Mass
from jtik.robot.tree import Joint
from jtik.types import Array

if TYPE_CHECKING:
    from jtik.robot.model import Robot


def merged(masses: Iterable[Mass]) -> Mass:
    """Several masses on one frame as one, about their common centre of mass."""
    parts = [mass for mass in masses if mass.mass > 0]
    if len(parts) == 1:
        return parts[0]
    total = sum(part.mass for part in parts)
    if total == 0:
        return Mass(0.0)
    center = sum((part.mass / total * part.center for part in parts), np.zeros(3))
    inertia = sum((part.inertia + part.mass * steiner(part.center - center) for part in parts), np.zeros((3, 3)))
    return Mass(total, center, inertia)


def steiner(offset: Array) -> Array:
    """The inertia of a unit mass at ``offset`` (3,) [m] about the origin, (3, 3) [m^2]."""
    tensor: Array = offset @ offset * np.eye(3) - np.outer(offset, offset)
    return tensor


def moved(mass: Mass, pose: Array) -> Mass:
    """The mass in a frame in which its own frame is at ``pose`` (4, 4) [m]."""
    R = pose[:3, :3]
    return Mass(mass.mass, pose[:3, 3] + R @ mass.center, R @ mass.inertia @ R.T)


def rigid_bodies(robot: Robot) -> dict[str, Mass]:
    """The mass that each moving joint carries without the joints after it, by the joint's child frame.

    Masses on frames that do not move are left out.
    """
    parts: dict[str, list[Mass]] = {}
    for frame, mass in robot.masses.items():
        pose, path = np.eye(4), list(robot.path(frame))
        while path and not path[-1].is_moving:
            pose = path.pop().origin @ pose
        if path:
            parts.setdefault(path[-1].child, []).append(moved(mass, pose))
    return {frame: merged(masses) for frame, masses in parts.items()}


def moving_joints(robot: Robot) -> list[tuple[Joint, Joint | None]]:
    """The joints that move, mimic joints among them, inner ones first, each with the next moving joint inward."""
    joints = sorted((joint for joint in robot.joints if joint.is_moving), key=lambda each: len(robot.path(each.child)))
    found: list[tuple[Joint, Joint | None]] = []
    for joint in joints:
        inner = [each for each in robot.path(joint.parent) if each.is_moving]
        found.append((joint, inner[-1] if inner else None))
    return found


def massless_frames(robot: Robot, bodies: Mapping[str, Mass]) -> tuple[str, ...]:
    """The child frames of the joints that move no mass, in the order of the joints."""
    carrying = {joint.child for frame in bodies for joint in robot.path(frame)}
    return tuple(joint.child for joint in robot.joints if joint.is_moving and joint.child not in carrying)
