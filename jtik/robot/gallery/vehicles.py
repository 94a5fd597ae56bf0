"""Arms on vehicles, and planar robots."""

from __future__ import annotations

import math

import numpy as np

from jtik.geometry import Box, Solid
from jtik.robot.chains import planar_joints, vehicle_joints
from jtik.robot.gallery.gallery_robot import QUARTER, Fixture, GalleryRobot, body, fixed, pose_at
from jtik.robot.gallery.panda import panda
from jtik.robot.joint_type import JointType
from jtik.robot.tree import Joint

_FREE = (-math.inf, math.inf, math.inf)

# Clearpath Ridgeback data sheet (May 2025): 0.960 x 0.793 x 0.311 m, 1.1 m/s in every direction. Rotation: the limit of
# Clearpath's own controller, ridgeback_control.
_LENGTH, _WIDTH, _HEIGHT = 0.960, 0.793, 0.311
_SPEED, _ROTATION_SPEED = 1.1, 4.0

# The chassis of ridgeback_description, Clearpath's own robot description; without rockers and wheels.
_CHASSIS = body(
    165.304,
    (0.012, 0.002, 0.067),
    (4.4744, 7.1624, 4.6155, 0.03098, 0.003647, 0.1228),
    (QUARTER, 0.0, QUARTER),
)


def planar10() -> GalleryRobot:
    """Ten unit links in the plane, without limits."""
    return GalleryRobot(
        name="planar10",
        summary="planar arm of ten unit links",
        source="Das, Slotine and Sheridan 1988, Figure 2.2",
        mass_source="none: the paper has no masses",
        joints=tuple(planar_joints(10, _FREE)),
        planar=True,
        home=(0.1,) * 10,
    )


def vehicle3() -> GalleryRobot:
    """A planar vehicle with a heading and three unit links, without limits."""
    return GalleryRobot(
        name="vehicle3",
        summary="planar vehicle (x, y, heading) with three unit links",
        source="Das, Slotine and Sheridan 1988, Appendix B",
        mass_source="none: the paper has no masses",
        joints=tuple(vehicle_joints(3, True, _FREE, _FREE)),
        planar=True,
        home=(0.0, 0.0, 0.0, 0.5, 0.5, 0.5),
    )


def vehicle_panda() -> GalleryRobot:
    """An omnidirectional vehicle with a Panda on the middle of its deck; the arm's frames and joints as in `panda`."""
    arm = panda()
    chassis = Box(pose_at((0.0, 0.0, _HEIGHT / 2)), np.array([_LENGTH, _WIDTH, _HEIGHT]) / 2)
    shapes: dict[str, tuple[Solid, ...]] = {"vehicle": (chassis,)}
    shapes |= {frame: tuple(solids) for frame, solids in arm.shapes.items()}
    return GalleryRobot(
        name="vehicle_panda",
        summary="Clearpath Ridgeback (x, y, heading) with a Panda, 10 joints",
        source=f"Clearpath Ridgeback data sheet, May 2025; {arm.source}",
        mass_source=f"ridgeback_description, Clearpath's own robot description, chassis; {arm.mass_source}",
        joints=(
            Joint("x", JointType.PRISMATIC, "base", "slide_x", axis=np.array([1.0, 0.0, 0.0]), velocity_limit=_SPEED),
            Joint(
                "y", JointType.PRISMATIC, "slide_x", "slide_y", axis=np.array([0.0, 1.0, 0.0]), velocity_limit=_SPEED
            ),
            Joint("heading", JointType.REVOLUTE, "slide_y", "vehicle", velocity_limit=_ROTATION_SPEED),
            fixed(Fixture(arm.base, "vehicle", (0.0, 0.0, _HEIGHT))),
            *arm.joints,
        ),
        shapes=shapes,
        masses={"vehicle": _CHASSIS, **arm.masses},
        home=(0.0, 0.0, 0.0, *arm.home),
    )
