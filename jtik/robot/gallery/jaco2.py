"""Kinova JACO 2 with six joints, a spherical wrist and two fingers that do not move here."""

from __future__ import annotations

import math

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

_PI, _INF = math.pi, math.inf

# Ranges and speeds: Kinova Gen2 ultra lightweight robot user guide (UG-009), as in kinova_description, Kinova's own
# robot description: 1, 4 and 6 are unlimited; 36 degrees/s for the large actuators, 48 for the small ones. Torques:
# that description.
_SHOULDER, _ELBOW, _WRIST = ((math.radians(low), math.radians(360 - low)) for low in (47, 19, 30))
_LARGE, _SMALL = math.radians(36), math.radians(48)

# Origins: kinova_description, j2s6. They are the lengths D1 = 0.2755, D2 = 0.4100, D3 = 0.2073, D4 = D5 = 0.10375,
# D6 = 0.1600 and e2 = 0.0098 m of the user guide, D1 and e2 in two parts.
_JOINTS = (
    Revolute("j2s6s200_joint_1", "j2s6s200_link_1", (0, 0, 0.15675), (0, _PI, 0), -_INF, _INF, _LARGE, 40.0),
    Revolute(
        "j2s6s200_joint_2", "j2s6s200_link_2", (0, 0.0016, -0.11875), (-QUARTER, 0, _PI), *_SHOULDER, _LARGE, 80.0
    ),
    Revolute("j2s6s200_joint_3", "j2s6s200_link_3", (0, -0.41, 0), (0, _PI, 0), *_ELBOW, _LARGE, 40.0),
    Revolute(
        "j2s6s200_joint_4", "j2s6s200_link_4", (0, 0.2073, -0.0114), (-QUARTER, 0, _PI), -_INF, _INF, _SMALL, 20.0
    ),
    Revolute("j2s6s200_joint_5", "j2s6s200_link_5", (0, 0, -0.10375), (QUARTER, 0, _PI), *_WRIST, _SMALL, 20.0),
    Revolute("j2s6s200_joint_6", "j2s6s200_link_6", (0, 0.10375, 0), (-QUARTER, 0, _PI), -_INF, _INF, _SMALL, 20.0),
)
_FIXTURES = (Fixture("j2s6s200_end_effector", "j2s6s200_link_6", (0.0, 0.0, -0.16), (_PI, QUARTER, 0.0)),)

# Around the meshes of kinova_description; the last capsule holds the two fingers.
_SHAPES = {
    "j2s6s200_link_base": (capsule((0.0, 0.0, 0.03), (0.0, 0.0, 0.135), 0.05),),
    "j2s6s200_link_1": (capsule((0.0, 0.0, -0.015), (0.0, -0.015, -0.12), 0.05),),
    "j2s6s200_link_2": (capsule((0.0, 0.0, -0.015), (0.0, -0.41, -0.015), 0.05),),
    "j2s6s200_link_3": (capsule((0.0, 0.0, -0.015), (0.0, 0.18, -0.012), 0.05),),
    "j2s6s200_link_4": (capsule((0.0, 0.0, -0.015), (0.0, 0.015, -0.105), 0.04),),
    "j2s6s200_link_5": (capsule((0.0, 0.0, -0.015), (0.0, 0.085, 0.0), 0.04),),
    "j2s6s200_link_6": (
        capsule((0.0, 0.0, -0.03), (0.0, 0.0, -0.12), 0.06),
        capsule((0.0, -0.075, -0.13), (0.0, 0.075, -0.13), 0.045),
    ),
}

# kinova_description: masses, centres, and inertias of cylinders. The two fingers, 20 g each, are left out.
_MASSES = {
    "j2s6s200_link_base": body(0.46784, (0.0, 0.0, 0.1255), round_moments(0.000374272, 0.000951270861568)),
    "j2s6s200_link_1": body(0.7477, (0.0, -0.002, -0.0605), round_moments(0.00059816, 0.00152031725204)),
    "j2s6s200_link_2": body(0.99, (0.0, -0.2065, -0.01), round_moments(0.000792, 0.010502207991), (QUARTER, 0.0, 0.0)),
    "j2s6s200_link_3": body(
        0.6763, (0.0, 0.081, -0.0086), round_moments(0.000304335, 0.00142022431908), (QUARTER, 0.0, 0.0)
    ),
    "j2s6s200_link_4": body(0.463, (0.0, 0.0028848942, -0.0541932613), round_moments(9.26e-5, 0.0004321316048)),
    "j2s6s200_link_5": body(
        0.463, (0.0, 0.0497208855, -0.0028562765), round_moments(9.26e-5, 0.0004321316048), (QUARTER, 0.0, 0.0)
    ),
    "j2s6s200_link_6": body(0.99, (0.0, 0.0, -0.06), round_moments(0.0005816, 0.0003453236187)),
}


def jaco2() -> GalleryRobot:
    """The arm: the tip is "j2s6s200_end_effector", between the fingers."""
    return GalleryRobot(
        name="jaco2",
        summary="Kinova JACO 2, 6 joints, spherical wrist",
        source="Kinova Gen2 user guide; kinova_description",
        mass_source="kinova_description, Kinova's own robot description",
        joints=chain("j2s6s200_link_base", _JOINTS, _FIXTURES, tip="j2s6s200_end_effector"),
        base="j2s6s200_link_base",
        shapes=_SHAPES,
        masses=_MASSES,
        home=tuple(math.radians(angle) for angle in (275, 167, 57, 241, 83, 75)),
    )
