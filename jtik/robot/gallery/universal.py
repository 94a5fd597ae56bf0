"""Universal Robots UR5e and UR5: the same six joints with other lengths."""

from __future__ import annotations

import math
from dataclasses import dataclass

from jtik.geometry import Capsule
from jtik.robot.gallery.gallery_robot import QUARTER, Fixture, GalleryRobot, Revolute, capsule, chain


@dataclass(frozen=True)
class _Lengths:
    """The lengths in which the arms differ [m].

    Attributes:
        d1: link offset of the Denavit-Hartenberg table (standard convention).
        a2: link length of that table.
        a3: link length of that table.
        d4: link offset of that table.
        d5: link offset of that table.
        d6: link offset of that table.
        shoulder: distance of the upper arm from the plane of the base axis.
        elbow: distance of the forearm from the plane of the base axis.
    """

    d1: float
    a2: float
    a3: float
    d4: float
    d5: float
    d6: float
    shoulder: float
    elbow: float


# Universal Robots, "DH Parameters for calculations of kinematics and dynamics" (support article 45257), tables UR5e
# and UR5. The last two are used for the capsules only: from the makers' robot descriptions.
_UR5E = _Lengths(0.1625, -0.425, -0.3922, 0.1333, 0.0997, 0.0996, shoulder=0.138, elbow=0.007)
_UR5 = _Lengths(0.089159, -0.425, -0.39225, 0.10915, 0.09465, 0.0823, shoulder=0.13585, elbow=0.01615)

# Every joint +-360 degrees and 180 degrees/s (technical details UR5e, e-Series user manual; UR5, CB3 user manual). The
# elbow cannot pass the upper arm: Universal Robots' own robot description gives it +-180 degrees.
_FULL, _HALF, _SPEED = 2 * math.pi, math.pi, math.pi


def _joints(at: _Lengths) -> tuple[Revolute, ...]:
    """Frames of Universal Robots' own description: on the joints, z along the axes; the base looks backwards."""
    return (
        Revolute("shoulder_pan_joint", "shoulder_link", (0, 0, at.d1), (0, 0, math.pi), -_FULL, _FULL, _SPEED),
        Revolute("shoulder_lift_joint", "upper_arm_link", (0, 0, 0), (QUARTER, 0, 0), -_FULL, _FULL, _SPEED),
        Revolute("elbow_joint", "forearm_link", (at.a2, 0, 0), (0, 0, 0), -_HALF, _HALF, _SPEED),
        Revolute("wrist_1_joint", "wrist_1_link", (at.a3, 0, at.d4), (0, 0, 0), -_FULL, _FULL, _SPEED),
        Revolute("wrist_2_joint", "wrist_2_link", (0, -at.d5, 0), (QUARTER, 0, 0), -_FULL, _FULL, _SPEED),
        Revolute("wrist_3_joint", "wrist_3_link", (0, at.d6, 0), (-QUARTER, 0, 0), -_FULL, _FULL, _SPEED),
    )


def _shapes(at: _Lengths) -> dict[str, tuple[Capsule, ...]]:
    """Around the housings of the joints and the tubes between them."""
    upper, fore = at.shoulder, at.elbow
    return {
        "base_link": (
            capsule((0.0, 0.0, 0.0), (0.0, 0.0, at.d1 - 0.06), 0.08),
            capsule((0.0, 0.0, 0.01), (0.0, -0.07, 0.01), 0.045),
        ),
        "shoulder_link": (capsule((0.0, 0.0, -0.015), (0.0, -0.02, 0.0), 0.086),),
        "upper_arm_link": (
            capsule((0.0, 0.0, upper - 0.02), (0.0, 0.0, upper + 0.02), 0.075),
            capsule((0.0, 0.0, upper), (at.a2, 0.0, upper), 0.06),
            capsule((at.a2, 0.0, upper - 0.02), (at.a2, 0.0, upper + 0.02), 0.075),
        ),
        "forearm_link": (
            capsule((0.0, 0.0, fore - 0.005), (0.0, 0.0, fore + 0.03), 0.065),
            capsule((0.0, 0.0, fore), (at.a3, 0.0, fore), 0.05),
            capsule((at.a3, 0.0, fore - 0.02), (at.a3, 0.0, fore + 0.02), 0.05),
        ),
        "wrist_1_link": (capsule((0.0, 0.0, -0.01), (0.0, 0.0, 0.01), 0.064),),
        "wrist_2_link": (capsule((0.0, 0.0, -0.01), (0.0, 0.0, 0.01), 0.064),),
        "wrist_3_link": (capsule((0.0, 0.0, -0.03), (0.0, 0.0, -0.02), 0.045),),
    }


def _arm(name: str, summary: str, lengths: _Lengths) -> GalleryRobot:
    fixtures = (Fixture("base", "base_link", rpy=(0.0, 0.0, math.pi)), Fixture("tool0", "wrist_3_link"))
    return GalleryRobot(
        name=name,
        summary=summary,
        source="Universal Robots, DH parameters for calculations of kinematics and dynamics",
        joints=chain("base_link", _joints(lengths), fixtures, tip="tool0"),
        base="base_link",
        shapes=_shapes(lengths),
        # the tool points down in front of the arm
        home=(0.0, -QUARTER, QUARTER, -QUARTER, -QUARTER, 0.0),
    )


def ur5e() -> GalleryRobot:
    """The e-Series arm: "base" is the controller's frame, flange and tip are "tool0"."""
    return _arm("ur5e", "Universal Robots UR5e, 6 joints", _UR5E)


def ur5() -> GalleryRobot:
    """The CB3 arm; frames as those of the UR5e."""
    return _arm("ur5", "Universal Robots UR5 (CB3), 6 joints", _UR5)
