"""Universal Robots UR5e and UR5: the same six joints with other lengths."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from jtik.geometry import Capsule
from jtik.robot.gallery.gallery_robot import (
    QUARTER,
    Fixture,
    GalleryRobot,
    Revolute,
    body,
    capsule,
    chain,
    round_moments,
)
from jtik.robot.masses_and_shapes import Mass


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
# Largest torques of the large and the small joints [N m]: Universal Robots' own robot description.
_LARGE, _SMALL = 150.0, 28.0

# Masses and centres of mass: the support article, with the centres in the frames of Universal Robots' own robot
# description. Inertias: that description, for the UR5 those of cylinders. It calls the mass of the base uncertain.
_BASE = body(4.0, (0.0, 0.0, 0.0), round_moments(0.0072, 0.00443333))
_UR5E_MASSES = {
    "base_link": _BASE,
    "shoulder_link": body(
        3.761,
        (0.0, -0.00193, -0.02561),
        (0.0070021, 0.00648091, 0.00657286, 7.3e-7, -1.053e-5, 0.00049994),
        (QUARTER, 0.0, 0.0),
    ),
    "upper_arm_link": body(
        8.058, (-0.2125, 0.0, 0.11336), (0.01505885, 0.33388086, 0.33247207, -5.4e-5, 5.63e-6, -1.81e-6)
    ),
    "forearm_link": body(
        2.846, (-0.2422, 0.0, 0.0265), (0.00399632, 0.07879254, 0.0784851, -1.365e-5, 0.00137272, -6.6e-6)
    ),
    "wrist_1_link": body(
        1.37,
        (0.0, -0.01634, -0.0018),
        (0.00165491, 0.00135962, 0.00126279, -2.82e-6, -4.38e-6, 0.00010157),
        (QUARTER, 0.0, 0.0),
    ),
    "wrist_2_link": body(
        1.3,
        (0.0, 0.01634, -0.0018),
        (0.00135617, 0.00127827, 0.00096614, -2.74e-6, 4.44e-6, -5.048e-5),
        (-QUARTER, 0.0, 0.0),
    ),
    "wrist_3_link": body(0.365, (0.0, 0.0, -0.001159), (0.00018694, 0.00018908, 0.00025756, 6e-8, -1.7e-7, -9.2e-7)),
}
_UR5_MASSES = {
    "base_link": _BASE,
    "shoulder_link": body(3.7, (0.0, -0.00193, -0.02561), round_moments(0.01040625, 0.01497236)),
    "upper_arm_link": body(8.393, (-0.2125, 0.0, 0.11336), round_moments(0.0151074, 0.13388584), (0.0, QUARTER, 0.0)),
    "forearm_link": body(2.33, (-0.24225, 0.0, 0.0265), round_moments(0.004095, 0.0312168), (0.0, QUARTER, 0.0)),
    "wrist_1_link": body(1.219, (0.0, -0.01634, -0.0018), round_moments(0.0021942, 0.00201389)),
    "wrist_2_link": body(1.219, (0.0, 0.01634, -0.0018), round_moments(0.0021942, 0.00183104)),
    "wrist_3_link": body(0.1879, (0.0, 0.0, -0.001159), round_moments(0.00013212, 8.062e-5)),
}


def _joints(at: _Lengths) -> tuple[Revolute, ...]:
    """Frames of Universal Robots' own description: on the joints, z along the axes; the base looks backwards."""
    return (
        Revolute("shoulder_pan_joint", "shoulder_link", (0, 0, at.d1), (0, 0, math.pi), -_FULL, _FULL, _SPEED, _LARGE),
        Revolute("shoulder_lift_joint", "upper_arm_link", (0, 0, 0), (QUARTER, 0, 0), -_FULL, _FULL, _SPEED, _LARGE),
        Revolute("elbow_joint", "forearm_link", (at.a2, 0, 0), (0, 0, 0), -_HALF, _HALF, _SPEED, _LARGE),
        Revolute("wrist_1_joint", "wrist_1_link", (at.a3, 0, at.d4), (0, 0, 0), -_FULL, _FULL, _SPEED, _SMALL),
        Revolute("wrist_2_joint", "wrist_2_link", (0, -at.d5, 0), (QUARTER, 0, 0), -_FULL, _FULL, _SPEED, _SMALL),
        Revolute("wrist_3_joint", "wrist_3_link", (0, at.d6, 0), (-QUARTER, 0, 0), -_FULL, _FULL, _SPEED, _SMALL),
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


def _arm(name: str, summary: str, lengths: _Lengths, masses: Mapping[str, Mass]) -> GalleryRobot:
    fixtures = (Fixture("base", "base_link", rpy=(0.0, 0.0, math.pi)), Fixture("tool0", "wrist_3_link"))
    return GalleryRobot(
        name=name,
        summary=summary,
        source="Universal Robots, DH parameters for calculations of kinematics and dynamics",
        mass_source="the same article; inertias of Universal_Robots_ROS2_Description",
        joints=chain("base_link", _joints(lengths), fixtures, tip="tool0"),
        base="base_link",
        shapes=_shapes(lengths),
        masses=masses,
        # the tool points down in front of the arm
        home=(0.0, -QUARTER, QUARTER, -QUARTER, -QUARTER, 0.0),
    )


def ur5e() -> GalleryRobot:
    """The e-Series arm: "base" is the controller's frame, flange and tip are "tool0"."""
    return _arm("ur5e", "Universal Robots UR5e, 6 joints", _UR5E, _UR5E_MASSES)


def ur5() -> GalleryRobot:
    """The CB3 arm; frames as those of the UR5e."""
    return _arm("ur5", "Universal Robots UR5 (CB3), 6 joints", _UR5, _UR5_MASSES)
