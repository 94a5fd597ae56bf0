"""Franka Emika Panda: seven joints and the hand; its fingers do not move here."""

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
from jtik.robot.rigid_bodies import merged

# Joints: Franka Control Interface documentation, "Control parameters specifications", table of the
# Denavit-Hartenberg parameters (Craig's convention, so that every frame is on its joint) and table of the joint
# space limits, with the torques.
_JOINTS = (
    Revolute("panda_joint1", "panda_link1", (0.0, 0.0, 0.333), (0.0, 0.0, 0.0), -2.8973, 2.8973, 2.1750, 87.0),
    Revolute("panda_joint2", "panda_link2", (0.0, 0.0, 0.0), (-QUARTER, 0.0, 0.0), -1.7628, 1.7628, 2.1750, 87.0),
    Revolute("panda_joint3", "panda_link3", (0.0, -0.316, 0.0), (QUARTER, 0.0, 0.0), -2.8973, 2.8973, 2.1750, 87.0),
    Revolute("panda_joint4", "panda_link4", (0.0825, 0.0, 0.0), (QUARTER, 0.0, 0.0), -3.0718, -0.0698, 2.1750, 87.0),
    Revolute("panda_joint5", "panda_link5", (-0.0825, 0.384, 0.0), (-QUARTER, 0.0, 0.0), -2.8973, 2.8973, 2.6100, 12.0),
    Revolute("panda_joint6", "panda_link6", (0.0, 0.0, 0.0), (QUARTER, 0.0, 0.0), -0.0175, 3.7525, 2.6100, 12.0),
    Revolute("panda_joint7", "panda_link7", (0.088, 0.0, 0.0), (QUARTER, 0.0, 0.0), -2.8973, 2.8973, 2.6100, 12.0),
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

# Franka publishes none. Identified on a robot by Gaz et al. 2019, as in franka_description, Franka's own robot
# description, which adds those of the hand and of its two fingers, here closed.
_MASSES = {
    "panda_link0": body(
        0.629769, (-0.041018, -0.00014, 0.049974), (0.00315, 0.00388, 0.004285, 8.2904e-7, 0.00015, 8.2299e-6)
    ),
    "panda_link1": body(
        4.970684, (0.003875, 0.002081, -0.04762), (0.70337, 0.70661, 0.009117, -0.000139, 0.006772, 0.019169)
    ),
    "panda_link2": body(
        0.646926, (-0.003141, -0.02872, 0.003495), (0.007962, 0.02811, 0.025995, -0.003925, 0.010254, 0.000704)
    ),
    "panda_link3": body(
        3.228604, (0.027518, 0.039252, -0.066502), (0.037242, 0.036155, 0.01083, -0.004761, -0.011396, -0.012805)
    ),
    "panda_link4": body(
        3.587895, (-0.05317, 0.104419, 0.027454), (0.025853, 0.019552, 0.028323, 0.007796, -0.001332, 0.008641)
    ),
    "panda_link5": body(
        1.225946, (-0.011953, 0.041065, -0.038437), (0.035549, 0.029474, 0.008627, -0.002117, -0.004037, 0.000229)
    ),
    "panda_link6": body(
        1.666555, (0.060149, -0.014117, -0.010517), (0.001964, 0.004354, 0.005433, 0.000109, -0.001158, 0.000341)
    ),
    "panda_link7": body(
        0.735522, (0.010517, -0.004252, 0.061597), (0.012516, 0.010027, 0.004815, -0.000428, -0.001196, -0.000741)
    ),
    "panda_hand": merged(
        [
            body(0.73, (-0.01, 0.0, 0.03), (0.001, 0.0025, 0.0017, 0.0, 0.0, 0.0)),
            body(0.03, (0.0, 0.0, 0.0584), round_moments(1.5e-6, 4.75e-6)),
        ]
    ),
}


def panda() -> GalleryRobot:
    """The arm with its hand: flange "panda_link8", tip at the hand's tool centre."""
    return GalleryRobot(
        name="panda",
        summary="Franka Emika Panda, 7 joints, with its hand",
        source="Franka Control Interface documentation, control parameters",
        mass_source="identified by Gaz et al. 2019, as in franka_description",
        joints=chain("panda_link0", _JOINTS, _FIXTURES, tip="panda_hand_tcp"),
        base="panda_link0",
        shapes=_SHAPES,
        masses=_MASSES,
        # Franka's own ready posture
        home=(0.0, -math.pi / 4, 0.0, -3 * math.pi / 4, 0.0, math.pi / 2, math.pi / 4),
    )
