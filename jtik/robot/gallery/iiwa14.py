"""KUKA LBR iiwa 14 R820."""

from __future__ import annotations

import math

from jtik.robot.gallery.gallery_robot import QUARTER, Fixture, GalleryRobot, Revolute, capsule, chain

_PI = math.pi

# Axes A1 to A7: KUKA, "LBR iiwa 7 R800, LBR iiwa 14 R820 Specification", section 4.3.2, axis data: range [degrees],
# speed with rated payload [degrees/s].
_AXES = ((170, 85), (120, 85), (170, 100), (120, 75), (170, 130), (120, 135), (175, 135))

# Heights 0.360, 0.420, 0.400 and 0.126 m: the same document, principal dimensions. They are cut where the links meet,
# as in the widespread robot descriptions, of which the frames have the names.
_ORIGINS = (
    ((0.0, 0.0, 0.1575), (0.0, 0.0, 0.0)),
    ((0.0, 0.0, 0.2025), (QUARTER, 0.0, _PI)),
    ((0.0, 0.2045, 0.0), (QUARTER, 0.0, _PI)),
    ((0.0, 0.0, 0.2155), (QUARTER, 0.0, 0.0)),
    ((0.0, 0.1845, 0.0), (-QUARTER, _PI, 0.0)),
    ((0.0, 0.0, 0.2155), (QUARTER, 0.0, 0.0)),
    ((0.0, 0.081, 0.0), (-QUARTER, _PI, 0.0)),
)
_FLANGE = 0.045

# Around the links as the widespread meshes have them.
_SHAPES = {
    "iiwa_link_0": (capsule((-0.035, 0.0, 0.055), (0.0, 0.0, 0.07), 0.14),),
    "iiwa_link_1": (capsule((0.0, 0.0, 0.03), (0.0, -0.03, 0.205), 0.095),),
    "iiwa_link_2": (capsule((0.0, 0.0, 0.04), (0.0, 0.14, 0.0), 0.095),),
    "iiwa_link_3": (capsule((0.0, 0.0, 0.04), (0.0, 0.04, 0.215), 0.08),),
    "iiwa_link_4": (capsule((0.0, 0.0, 0.04), (0.0, 0.145, 0.0), 0.08),),
    "iiwa_link_5": (
        capsule((0.0, 0.0, 0.025), (0.0, 0.025, 0.07), 0.075),
        capsule((0.0, 0.04, 0.08), (0.0, 0.065, 0.215), 0.055),
    ),
    "iiwa_link_6": (capsule((0.0, -0.015, 0.0), (0.0, 0.02, 0.0), 0.08),),
    "iiwa_link_7": (capsule((0.0, 0.0, 0.0), (0.0, 0.0, 0.02), 0.065),),
}


def iiwa14() -> GalleryRobot:
    """The arm: flange and tip are "iiwa_link_ee"."""
    joints = [
        Revolute(
            f"iiwa_joint_{k}", f"iiwa_link_{k}", *origin, math.radians(-reach), math.radians(reach), math.radians(speed)
        )
        for k, (origin, (reach, speed)) in enumerate(zip(_ORIGINS, _AXES, strict=True), start=1)
    ]
    fixtures = (Fixture("iiwa_link_ee", "iiwa_link_7", (0.0, 0.0, _FLANGE)),)
    return GalleryRobot(
        name="iiwa14",
        summary="KUKA LBR iiwa 14 R820, 7 joints",
        source="KUKA, LBR iiwa specification, 4.3.2",
        mass_source="none: KUKA publishes neither masses nor inertias of the links",
        joints=chain("iiwa_link_0", joints, fixtures, tip="iiwa_link_ee"),
        base="iiwa_link_0",
        shapes=_SHAPES,
        # bent, the flange pointing down
        home=tuple(math.radians(angle) for angle in (0, 30, 0, -90, 0, 60, 0)),
    )
