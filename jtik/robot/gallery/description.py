"""A built-in robot as a table: what the modules of the gallery fill in, and what becomes a `Robot`."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from jtik.geometry import Capsule, Solid
from jtik.robot.dh import shift, turn_x, turn_z
from jtik.robot.joints import JointType
from jtik.robot.rotation import snapped
from jtik.robot.tree import Joint
from jtik.types import Array

Triple: TypeAlias = tuple[float, float, float]

QUARTER = math.pi / 2
"""A quarter turn [rad]."""


class Hinge(NamedTuple):
    """A joint that turns about z, and the link it moves, as a row of a chain.

    Attributes:
        joint: name of the joint.
        link: name of the link and its frame.
        xyz: where the joint sits in the frame of the link before [m].
        rpy: how it is turned there: about the fixed axes x, then y, then z [rad].
        lower: lower limit [rad].
        upper: upper limit [rad].
        speed: greatest speed [rad/s].
    """

    joint: str
    link: str
    xyz: Triple
    rpy: Triple
    lower: float
    upper: float
    speed: float


class Fixture(NamedTuple):
    """A frame fixed on another: name, what it sits on, where [m] and how turned (as in `Hinge`) [rad]."""

    frame: str
    parent: str
    xyz: Triple = (0.0, 0.0, 0.0)
    rpy: Triple = (0.0, 0.0, 0.0)


@dataclass(frozen=True, kw_only=True)
class Description:
    """A robot of the gallery.

    Attributes:
        name: what it is called.
        summary: what it is, in a line.
        source: where its figures are published.
        home: a posture to start from, away from singularities, one number a joint.
        joints: the tree.
        base: the root frame.
        planar: whether its workspace is the x-y plane.
        shapes: solids on the links.
    """

    name: str
    summary: str
    source: str
    home: tuple[float, ...]
    joints: tuple[Joint, ...]
    base: str = "base"
    planar: bool = False
    shapes: Mapping[str, Sequence[Solid]] = field(default_factory=dict)

    def arguments(self) -> dict[str, Any]:
        """The arguments of `Robot`; its tip is the frame "tip"."""
        return {
            "joints": self.joints,
            "name": self.name,
            "planar": self.planar,
            "base": self.base,
            "tip": "tip",
            "shapes": self.shapes,
            "keyframes": {"home": self.home},
        }


def chain(base: str, hinges: Sequence[Hinge], fixtures: Sequence[Fixture], *, tip: str) -> tuple[Joint, ...]:
    """The joints of a serial arm: ``hinges`` one after another on ``base``, then what is fixed on them.

    The frame "tip" coincides with the frame ``tip``.
    """
    joints = []
    parent = base
    for row in hinges:
        joints.append(
            Joint(
                row.joint,
                JointType.REVOLUTE,
                parent,
                row.link,
                origin=place(row.xyz, row.rpy),
                lower=row.lower,
                upper=row.upper,
                velocity_limit=row.speed,
            )
        )
        parent = row.link
    return (*joints, *(fixed(fixture) for fixture in (*fixtures, Fixture("tip", tip))))


def fixed(fixture: Fixture) -> Joint:
    """The fixed joint of a fixture, called like its frame."""
    origin = place(fixture.xyz, fixture.rpy)
    return Joint(fixture.frame, JointType.FIXED, fixture.parent, fixture.frame, origin=origin)


def place(xyz: Triple, rpy: Triple = (0.0, 0.0, 0.0)) -> Array:
    """The pose (4, 4) at ``xyz`` [m], turned by ``rpy`` [rad] about the fixed axes x, then y, then z.

    Quarter turns are exact.
    """
    roll, pitch, yaw = rpy
    pose = shift(*xyz) @ turn_z(yaw) @ _turn_y(pitch) @ turn_x(roll)
    pose[:3, :3] = snapped(pose[:3, :3])
    return pose


def capsule(start: Triple, end: Triple, radius: float) -> Capsule:
    """A capsule in the frame of its link: the ends of its axis and its radius [m]."""
    return Capsule(np.array(start), np.array(end), radius)


def _turn_y(angle: float) -> Array:
    # a turn about y is a turn about x seen from a frame turned about z
    return turn_z(QUARTER) @ turn_x(angle) @ turn_z(-QUARTER)
