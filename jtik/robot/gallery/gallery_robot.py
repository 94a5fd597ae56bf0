"""The tables of a built-in robot: rows of joints and fixed frames, and the `GalleryRobot` made of them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from jtik.geometry import Capsule, Solid
from jtik.robot.dh import rotation_x, rotation_z, translation
from jtik.robot.joint_type import JointType
from jtik.robot.masses_and_shapes import Mass
from jtik.robot.rotation import snapped
from jtik.robot.tree import Joint
from jtik.types import Array

Triple: TypeAlias = tuple[float, float, float]

QUARTER = math.pi / 2
"""A right angle [rad]."""


class Revolute(NamedTuple):
    """A revolute joint about z, and the link it moves: a row of a chain.

    Attributes:
        joint: name of the joint.
        link: name of the link and its frame.
        xyz: position of the joint in the frame of the previous link [m].
        rpy: orientation of the joint there: rotations about the fixed axes x, then y, then z [rad].
        lower: lower limit [rad].
        upper: upper limit [rad].
        speed: maximum speed [rad/s].
        effort: maximum torque [N m].
    """

    joint: str
    link: str
    xyz: Triple
    rpy: Triple
    lower: float
    upper: float
    speed: float
    effort: float = math.inf


class Fixture(NamedTuple):
    """A frame fixed on another one.

    Attributes:
        frame: name of the frame.
        parent: name of the frame that carries it.
        xyz: position in the parent [m].
        rpy: orientation in the parent, as in `Revolute` [rad].
    """

    frame: str
    parent: str
    xyz: Triple = (0.0, 0.0, 0.0)
    rpy: Triple = (0.0, 0.0, 0.0)


@dataclass(frozen=True, kw_only=True)
class GalleryRobot:
    """A robot of the gallery.

    Attributes:
        name: name of the robot.
        summary: one line of description.
        source: where its figures are published.
        mass_source: where its masses and inertias are published, or why it has none.
        home: a start configuration away from singularities, one number for each joint.
        joints: the tree of joints.
        base: name of the root frame.
        planar: whether its workspace is the x-y plane.
        shapes: solids on the links, by frame.
        masses: masses and inertias of the links, by frame.
    """

    name: str
    summary: str
    source: str
    mass_source: str
    home: tuple[float, ...]
    joints: tuple[Joint, ...]
    base: str = "base"
    planar: bool = False
    shapes: Mapping[str, Sequence[Solid]] = field(default_factory=dict)
    masses: Mapping[str, Mass] = field(default_factory=dict)

    def arguments(self) -> dict[str, Any]:
        """The arguments of `Robot`; the tip is the frame "tip"."""
        return {
            "joints": self.joints,
            "name": self.name,
            "planar": self.planar,
            "base": self.base,
            "tip": "tip",
            "shapes": self.shapes,
            "masses": self.masses,
            "keyframes": {"home": self.home},
        }


def chain(base: str, rows: Sequence[Revolute], fixtures: Sequence[Fixture], *, tip: str) -> tuple[Joint, ...]:
    """The joints of a serial arm on ``base``: ``rows`` one after another, then the fixed frames.

    The frame "tip" coincides with the frame ``tip``.
    """
    joints = []
    parent = base
    for row in rows:
        joints.append(
            Joint(
                row.joint,
                JointType.REVOLUTE,
                parent,
                row.link,
                origin=pose_at(row.xyz, row.rpy),
                lower=row.lower,
                upper=row.upper,
                velocity_limit=row.speed,
                effort_limit=row.effort,
            )
        )
        parent = row.link
    return (*joints, *(fixed(fixture) for fixture in (*fixtures, Fixture("tip", tip))))


def fixed(fixture: Fixture) -> Joint:
    """The fixed joint of a fixture, with the name of its frame."""
    origin = pose_at(fixture.xyz, fixture.rpy)
    return Joint(fixture.frame, JointType.FIXED, fixture.parent, fixture.frame, origin=origin)


def pose_at(xyz: Triple, rpy: Triple = (0.0, 0.0, 0.0)) -> Array:
    """The pose (4, 4) at ``xyz`` [m] with rotations ``rpy`` [rad] about the fixed axes x, then y, then z.

    Right angles are exact.
    """
    roll, pitch, yaw = rpy
    pose = translation(*xyz) @ rotation_z(yaw) @ _rotation_y(pitch) @ rotation_x(roll)
    pose[:3, :3] = snapped(pose[:3, :3])
    return pose


def capsule(start: Triple, end: Triple, radius: float) -> Capsule:
    """A capsule in the frame of its link: the ends of its axis and its radius [m]."""
    return Capsule(np.array(start), np.array(end), radius)


def body(mass: float, center: Triple, moments: tuple[float, ...], rpy: Triple = (0.0, 0.0, 0.0)) -> Mass:
    """A link: its mass [kg], its centre of mass [m] and its inertia about that.

    Args:
        mass: mass [kg].
        center: centre of mass in the frame of the link [m].
        moments: ixx, iyy, izz, ixy, ixz and iyz [kg m^2], in axes at the centre of mass.
        rpy: orientation of these axes in the frame of the link, as in `Revolute` [rad].
    """
    xx, yy, zz, xy, xz, yz = moments
    R = pose_at((0.0, 0.0, 0.0), rpy)[:3, :3]
    return Mass(mass, np.array(center), R @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ R.T)


def round_moments(along: float, across: float) -> tuple[float, ...]:
    """The moments for `body` of a body of revolution about z: about z, and about x and y [kg m^2]."""
    return (across, across, along, 0.0, 0.0, 0.0)


def _rotation_y(angle: float) -> Array:
    # a rotation about y is one about x, in a frame rotated by a right angle about z
    return rotation_z(QUARTER) @ rotation_x(angle) @ rotation_z(-QUARTER)
