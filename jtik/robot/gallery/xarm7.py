"""UFACTORY xArm 7."""

from __future__ import annotations

import math

from jtik.robot.gallery.gallery_robot import QUARTER, Fixture, GalleryRobot, Revolute, body, capsule, chain

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

# Largest torques [N m]: xarm_description, UFACTORY's own robot description.
_TORQUES = (50.0, 50.0, 30.0, 30.0, 30.0, 20.0, 20.0)

# UFACTORY, "Kinematic and Dynamic Parameters of UFACTORY xArm Series", as in xarm_description.
_MASSES = {
    "link_base": body(
        0.88556,
        (-0.021131, -0.0016302, 0.056488),
        (0.0030595, 0.0037783, 0.0020125, 0.00012259, -0.00062705, 0.00027023),
    ),
    "link1": body(
        2.382,
        (-0.0002, 0.02905, -0.01233),
        (0.0056905, 0.0049566, 0.003316654, -1.579e-5, 5.125e-6, -0.000873378),
    ),
    "link2": body(
        1.869, (0.00022, -0.12856, 0.01735), (0.0095989, 0.00382472, 0.007565669, 1.541e-6, 5.56e-6, -0.00317156)
    ),
    "link3": body(
        1.6383, (0.0466, -0.02463, -0.00768), (0.00310955, 0.00264483, 0.0026624, 0.00030837, -0.00058453, 0.000338893)
    ),
    "link4": body(
        1.7269, (0.07047, -0.11575, 0.012), (0.005889, 0.00359703, 0.00543244, 0.00137112, 0.00088143, -0.001762155)
    ),
    "link5": body(
        1.3203, (-0.00032, 0.01604, -0.026), (0.00534665, 0.0049779, 0.0013624, 1.5117e-5, -3.69e-7, -0.00022132)
    ),
    "link6": body(
        1.325, (0.06469, 0.03278, 0.02141), (0.0014745, 0.0019037, 0.0023652, -0.000488, 0.0002953, 0.00014749)
    ),
    "link7": body(0.17, (0.0, -0.00677, -0.01098), (9.3e-5, 5.87e-5, 0.000132, 0.0, 0.0, -3.6e-6)),
}

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
        Revolute(f"joint{k}", f"link{k}", *origin, math.radians(low), math.radians(high), _SPEED, torque)
        for k, (origin, (low, high), torque) in enumerate(zip(_ORIGINS, _RANGES, _TORQUES, strict=True), start=1)
    ]
    return GalleryRobot(
        name="xarm7",
        summary="UFACTORY xArm 7, 7 joints",
        source="UFACTORY, kinematic and dynamic parameters; xArm user manual",
        mass_source="UFACTORY, kinematic and dynamic parameters, as in xarm_description",
        joints=chain("link_base", joints, (Fixture("link_eef", "link7"),), tip="link_eef"),
        base="link_base",
        shapes=_SHAPES,
        masses=_MASSES,
        # bent, the flange pointing down
        home=tuple(math.radians(angle) for angle in (0, -20, 0, 50, 0, 70, 0)),
    )
