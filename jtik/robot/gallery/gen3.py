"""Kinova Gen3 with seven joints and the vision module."""

from __future__ import annotations

import math

from jtik.robot.gallery.gallery_robot import QUARTER, Fixture, GalleryRobot, Revolute, capsule, chain

_INF = math.inf

# Ranges: Kinova Gen3 user guide, angular range of the actuators: 1, 3, 5 and 7 are unlimited.
_SHOULDER, _ELBOW, _WRIST = (math.radians(angle) for angle in (128.9, 147.8, 120.3))
# Speeds: kortex_description, Kinova's own robot description, large and small actuators.
_LARGE, _SMALL = 1.3963, 1.2218

# Origins: kortex_description, which has the lengths of the user guide's Denavit-Hartenberg table with more digits.
_JOINTS = (
    Revolute("joint_1", "shoulder_link", (0.0, 0.0, 0.15643), (math.pi, 0, 0), -_INF, _INF, _LARGE),
    Revolute("joint_2", "half_arm_1_link", (0.0, 0.005375, -0.12838), (QUARTER, 0, 0), -_SHOULDER, _SHOULDER, _LARGE),
    Revolute("joint_3", "half_arm_2_link", (0.0, -0.21038, -0.006375), (-QUARTER, 0, 0), -_INF, _INF, _LARGE),
    Revolute("joint_4", "forearm_link", (0.0, 0.006375, -0.21038), (QUARTER, 0, 0), -_ELBOW, _ELBOW, _LARGE),
    Revolute("joint_5", "spherical_wrist_1_link", (0.0, -0.20843, -0.006375), (-QUARTER, 0, 0), -_INF, _INF, _SMALL),
    Revolute(
        "joint_6", "spherical_wrist_2_link", (0.0, 0.00017505, -0.10593), (QUARTER, 0, 0), -_WRIST, _WRIST, _SMALL
    ),
    Revolute("joint_7", "bracelet_link", (0.0, -0.10593, -0.00017505), (-QUARTER, 0, 0), -_INF, _INF, _SMALL),
)
_FIXTURES = (Fixture("end_effector_link", "bracelet_link", (0.0, 0.0, -0.061525), (math.pi, 0.0, 0.0)),)

# Around the tubes of the large and the small actuators; the last one holds the camera.
_SHAPES = {
    "base_link": (capsule((0.0, 0.0, 0.03), (0.0, 0.0, 0.13), 0.06),),
    "shoulder_link": (capsule((0.0, 0.0, 0.0), (0.0, 0.0, -0.13), 0.055),),
    "half_arm_1_link": (capsule((0.0, 0.0, -0.01), (0.0, -0.21, -0.01), 0.055),),
    "half_arm_2_link": (capsule((0.0, 0.0, 0.0), (0.0, 0.0, -0.21), 0.055),),
    "forearm_link": (capsule((0.0, 0.0, -0.01), (0.0, -0.21, -0.01), 0.055),),
    "spherical_wrist_1_link": (capsule((0.0, 0.0, 0.0), (0.0, 0.0, -0.105), 0.05),),
    "spherical_wrist_2_link": (capsule((0.0, 0.0, 0.0), (0.0, -0.105, 0.0), 0.05),),
    "bracelet_link": (
        capsule((0.0, 0.0, 0.0), (0.0, 0.0, -0.03), 0.045),
        capsule((-0.03, -0.055, -0.045), (0.03, -0.055, -0.045), 0.03),
    ),
}


def gen3() -> GalleryRobot:
    """The arm: flange and tip are "end_effector_link"."""
    return GalleryRobot(
        name="gen3",
        summary="Kinova Gen3, 7 joints",
        source="Kinova Gen3 user guide; kortex_description",
        joints=chain("base_link", _JOINTS, _FIXTURES, tip="end_effector_link"),
        base="base_link",
        shapes=_SHAPES,
        # Kinova's own home posture
        home=tuple(math.radians(angle) for angle in (0, 15, 180, -130, 0, 55, 90)),
    )
