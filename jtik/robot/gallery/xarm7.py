"""UFACTORY xArm 7."""

from __future__ import annotations

import math

from jtik.robot.gallery.gallery_robot import QUARTER, Fixture, GalleryRobot, Revolute, capsule, chain

_SPEED = math.pi

# Ranges [degrees] and 180 degrees/s: UFACTORY xArm user manual, technical specifications.
_RANGES = ((-360, 360), (-118, 120), (-360, 360), (-11, 225), (-360, 360), (-97, 180), (-360, 360))

# UFACTORY, "Kinematic and Dynamic Parameters of UFACTORY xArm Series", table of the modified (Craig's)
# Denavit-Hartenberg parameters: every frame is on its joint.
_ORIGINS = (
    ((0.0, 0.0, 0.267), (0.0, 0.0, 0.0)),
    ((0.0, 0.0, 0.0), (-QUARTER, 0.0, 0.0)),
    ((0.0, -0.293, 0.0), (QUARTER, 0.0, 0.0)),
    ((0.0525, 0.0, 0.0), (QUARTER, 0.0, 0.0)),
    ((0.0775, -0.3425, 0.0), (QUARTER, 0.0, 0.0)),
    ((0.0, 0.0, 0.0), (QUARTER, 0.0, 0.0)),
    ((0.076, 0.097, 0.0), (-QUARTER, 0.0, 0.0)),
)

# Around UFACTORY's meshes.
_SHAPES = {
    "link_base": (capsule((-0.01, 0.0, 0.035), (0.0, 0.0, 0.09), 0.085),),
    "link1": (
        capsule((0.0, 0.0, -0.1), (0.0, 0.0, 0.0), 0.06),
        capsule((0.0, 0.0, 0.0), (0.0, 0.05, 0.0), 0.055),
    ),
    "link2": (
        capsule((0.0, 0.0, 0.08), (0.0, -0.1, 0.08), 0.06),
        capsule((0.0, -0.1, 0.07), (0.0, -0.155, 0.0), 0.06),
        capsule((0.0, -0.08, 0.0), (0.0, -0.14, 0.0), 0.055),
    ),
    "link3": (
        capsule((0.0, 0.0, -0.065), (0.045, 0.02, 0.0), 0.06),
        capsule((0.0525, -0.045, 0.0), (0.0525, 0.02, 0.0), 0.055),
    ),
    "link4": (
        capsule((0.0, 0.0, 0.075), (0.0775, -0.08, 0.07), 0.055),
        capsule((0.0775, -0.08, 0.06), (0.0775, -0.13, 0.0), 0.055),
        capsule((0.0775, -0.06, 0.0), (0.0775, -0.12, 0.0), 0.055),
    ),
    "link5": (
        capsule((0.0, 0.0, -0.15), (0.0, 0.045, -0.05), 0.05),
        capsule((0.0, 0.045, -0.05), (0.0, 0.04, 0.0), 0.05),
    ),
    "link6": (capsule((0.02, 0.005, 0.02), (0.076, 0.02, 0.0), 0.062),),
    "link7": (capsule((0.0, 0.0, -0.03), (0.0, 0.0, -0.015), 0.053),),
}


def xarm7() -> GalleryRobot:
    """The arm: flange and tip are "link_eef"."""
    joints = [
        Revolute(f"joint{k}", f"link{k}", *origin, math.radians(low), math.radians(high), _SPEED)
        for k, (origin, (low, high)) in enumerate(zip(_ORIGINS, _RANGES, strict=True), start=1)
    ]
    return GalleryRobot(
        name="xarm7",
        summary="UFACTORY xArm 7, 7 joints",
        source="UFACTORY, kinematic and dynamic parameters; xArm user manual",
        joints=chain("link_base", joints, (Fixture("link_eef", "link7"),), tip="link_eef"),
        base="link_base",
        shapes=_SHAPES,
        # bent, the flange pointing down
        home=tuple(math.radians(angle) for angle in (0, -20, 0, 50, 0, 70, 0)),
    )
