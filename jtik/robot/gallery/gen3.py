"""Kinova Gen3 with seven joints and the vision module."""

from __future__ import annotations

import math

from jtik.robot.gallery.gallery_robot import QUARTER, Fixture, GalleryRobot, Revolute, body, capsule, chain

_INF = math.inf

# Ranges: Kinova Gen3 user guide, angular range of the actuators: 1, 3, 5 and 7 are unlimited.
_SHOULDER, _ELBOW, _WRIST = (math.radians(angle) for angle in (128.9, 147.8, 120.3))
# Speeds and torques: kortex_description, Kinova's own robot description, large and small actuators.
_LARGE, _SMALL = 1.3963, 1.2218

# Origins: kortex_description, which has the lengths of the user guide's Denavit-Hartenberg table with more digits.
_JOINTS = (
    Revolute("joint_1", "shoulder_link", (0.0, 0.0, 0.15643), (math.pi, 0, 0), -_INF, _INF, _LARGE, 39.0),
    Revolute(
        "joint_2", "half_arm_1_link", (0.0, 0.005375, -0.12838), (QUARTER, 0, 0), -_SHOULDER, _SHOULDER, _LARGE, 39.0
    ),
    Revolute("joint_3", "half_arm_2_link", (0.0, -0.21038, -0.006375), (-QUARTER, 0, 0), -_INF, _INF, _LARGE, 39.0),
    Revolute("joint_4", "forearm_link", (0.0, 0.006375, -0.21038), (QUARTER, 0, 0), -_ELBOW, _ELBOW, _LARGE, 39.0),
    Revolute(
        "joint_5", "spherical_wrist_1_link", (0.0, -0.20843, -0.006375), (-QUARTER, 0, 0), -_INF, _INF, _SMALL, 9.0
    ),
    Revolute(
        "joint_6", "spherical_wrist_2_link", (0.0, 0.00017505, -0.10593), (QUARTER, 0, 0), -_WRIST, _WRIST, _SMALL, 9.0
    ),
    Revolute("joint_7", "bracelet_link", (0.0, -0.10593, -0.00017505), (-QUARTER, 0, 0), -_INF, _INF, _SMALL, 9.0),
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

# kortex_description: the arm with the vision module.
_MASSES = {
    "base_link": body(1.697, (-0.000648, -0.000166, 0.084487), (0.004622, 0.004495, 0.002079, 9e-6, 6e-5, 9e-6)),
    "shoulder_link": body(1.3773, (-2.3e-5, -0.010364, -0.07336), (0.00457, 0.004831, 0.001409, 1e-6, 2e-6, 0.000448)),
    "half_arm_1_link": body(1.1636, (-4.4e-5, -0.09958, -0.013278), (0.011088, 0.001072, 0.011255, 5e-6, 0, -0.000691)),
    "half_arm_2_link": body(
        1.1636, (-4.4e-5, -0.006641, -0.117892), (0.010932, 0.011127, 0.001043, 0, -7e-6, 0.000606)
    ),
    "forearm_link": body(0.9302, (-1.8e-5, -0.075478, -0.015006), (0.008147, 0.000631, 0.008316, -1e-6, 0, -0.0005)),
    "spherical_wrist_1_link": body(
        0.6781, (1e-6, -0.009432, -0.063883), (0.001596, 0.001607, 0.000399, 0, 0, 0.000256)
    ),
    "spherical_wrist_2_link": body(0.6781, (1e-6, -0.045483, -0.00965), (0.001641, 0.00041, 0.001641, 0, 0, -0.000278)),
    "bracelet_link": body(
        0.5006, (-0.000281, -0.011402, -0.029798), (0.000587, 0.000369, 0.000609, 3e-6, 3e-6, 0.000118)
    ),
}


def gen3() -> GalleryRobot:
    """The arm: flange and tip are "end_effector_link"."""
    return GalleryRobot(
        name="gen3",
        summary="Kinova Gen3, 7 joints",
        source="Kinova Gen3 user guide; kortex_description",
        mass_source="kortex_description, Kinova's own robot description",
        joints=chain("base_link", _JOINTS, _FIXTURES, tip="end_effector_link"),
        base="base_link",
        shapes=_SHAPES,
        masses=_MASSES,
        # Kinova's own home posture
        home=tuple(math.radians(angle) for angle in (0, 15, 180, -130, 0, 55, 90)),
    )
