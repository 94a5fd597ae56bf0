"""Franka Emika Panda: seven joints and the hand; its fingers do not move here."""

from __future__ import annotations

import math

from jtik.robot.gallery.gallery_robot import QUARTER, Fixture, GalleryRobot, Revolute, capsule, chain

# Joints: Franka Control Interface documentation, "Control parameters specifications", table of the
# Denavit-Hartenberg parameters (Craig's convention, so that every frame is on its joint) and table of the joint
# space limits.
_JOINTS = (
    Revolute("panda_joint1", "panda_link1", (0.0, 0.0, 0.333), (0.0, 0.0, 0.0), -2.8973, 2.8973, 2.1750),
    Revolute("panda_joint2", "panda_link2", (0.0, 0.0, 0.0), (-QUARTER, 0.0, 0.0), -1.7628, 1.7628, 2.1750),
    Revolute("panda_joint3", "panda_link3", (0.0, -0.316, 0.0), (QUARTER, 0.0, 0.0), -2.8973, 2.8973, 2.1750),
    Revolute("panda_joint4", "panda_link4", (0.0825, 0.0, 0.0), (QUARTER, 0.0, 0.0), -3.0718, -0.0698, 2.1750),
    Revolute("panda_joint5", "panda_link5", (-0.0825, 0.384, 0.0), (-QUARTER, 0.0, 0.0), -2.8973, 2.8973, 2.6100),
    Revolute("panda_joint6", "panda_link6", (0.0, 0.0, 0.0), (QUARTER, 0.0, 0.0), -0.0175, 3.7525, 2.6100),
    Revolute("panda_joint7", "panda_link7", (0.088, 0.0, 0.0), (QUARTER, 0.0, 0.0), -2.8973, 2.8973, 2.6100),
)

# Flange: the same table. Hand: mounted at -45 degrees, its tool centre 0.1034 m ahead (franka_description, Franka's
# own robot description; Franka Hand product manual).
_FIXTURES = (
    Fixture("panda_link8", "panda_link7", (0.0, 0.0, 0.107)),
    Fixture("panda_hand", "panda_link8", rpy=(0.0, 0.0, -math.pi / 4)),
    Fixture("panda_hand_tcp", "panda_hand", (0.0, 0.0, 0.1034)),
)

# Around Franka's collision meshes; the fingers' capsule holds them open or closed.
_SHAPES = {
    "panda_link0": (capsule((-0.06, 0.0, 0.025), (0.0, 0.0, 0.055), 0.105),),
    "panda_link1": (
        capsule((0.0, 0.0, -0.17), (0.0, 0.0, 0.0), 0.065),
        capsule((0.0, -0.07, -0.005), (0.0, -0.035, -0.12), 0.065),
    ),
    "panda_link2": (
        capsule((0.0, -0.005, 0.07), (0.0, -0.12, 0.035), 0.065),
        capsule((0.0, 0.0, 0.0), (0.0, -0.17, 0.0), 0.065),
    ),
    "panda_link3": (capsule((0.0, 0.0, -0.085), (0.0825, 0.045, 0.0), 0.07),),
    "panda_link4": (capsule((0.0, 0.0, 0.045), (-0.0825, 0.085, 0.0), 0.07),),
    "panda_link5": (
        capsule((0.0, 0.0, -0.235), (0.0, 0.05, -0.08), 0.07),
        capsule((0.0, 0.06, -0.08), (0.0, 0.06, 0.0), 0.07),
    ),
    "panda_link6": (
        capsule((0.0, -0.01, 0.0), (0.085, -0.01, 0.0), 0.06),
        capsule((0.0, 0.0, 0.0), (0.088, 0.045, 0.0), 0.06),
    ),
    "panda_link7": (capsule((0.0, 0.0, 0.075), (0.035, 0.035, 0.08), 0.055),),
    "panda_hand": (
        capsule((0.0, -0.075, 0.025), (0.0, 0.075, 0.025), 0.05),
        capsule((0.0, -0.05, 0.083), (0.0, 0.05, 0.083), 0.035),
    ),
}


def panda() -> GalleryRobot:
    """The arm with its hand: flange "panda_link8", tip at the hand's tool centre."""
    return GalleryRobot(
        name="panda",
        summary="Franka Emika Panda, 7 joints, with its hand",
        source="Franka Control Interface documentation, control parameters",
        joints=chain("panda_link0", _JOINTS, _FIXTURES, tip="panda_hand_tcp"),
        base="panda_link0",
        shapes=_SHAPES,
        # Franka's own ready posture
        home=(0.0, -math.pi / 4, 0.0, -3 * math.pi / 4, 0.0, math.pi / 2, math.pi / 4),
    )
