"""Solids in the workspace and on the links of a robot, and signed distances to them as CasADi expressions.

- solids: `Point`, `Circle`, `Sphere`, `Capsule`, `Cylinder`, `Box`, `HalfSpace`, `Polygon`, their base `Solid`, and
  `Ball`, the base of the first three; `Obstacle` is any of them
- slots for a fixed number of obstacles, whose numbers are live parameters: `Slots`, `Slot`, `Distances`, `ABSENT`
- named obstacles and their file: `Scene`
- distances of points and segments: `point_to_ball`, `segment_to_ball`, and those to a capsule, a half-space, a box, a
  polygon and a cylinder, for which `Axis`, `Sides` and `in_axes` prepare the arguments
- closest points of a body and an obstacle, and the normal: `witness`, `Witness`
- the distance of two segments: `segment_to_segment`, `closest_points`, and for arrays `segment_distances`
- bodies and coordinate bounds: `enclosing_segment`, `enclosing_balls`, `bounds`
"""

from jtik.geometry.boxes import in_axes, point_to_box, segment_to_box
from jtik.geometry.cylinders import Axis, point_to_cylinder, segment_to_cylinder
from jtik.geometry.distances import (
    point_to_ball,
    point_to_capsule,
    point_to_half_space,
    segment_to_ball,
    segment_to_capsule,
    segment_to_half_space,
)
from jtik.geometry.enclosing import bounds, enclosing_balls, enclosing_segment
from jtik.geometry.flat import HalfSpace, Polygon
from jtik.geometry.obstacles import Obstacle, centers_and_radii
from jtik.geometry.pair_functions import Distances
from jtik.geometry.polygons import Sides, point_to_polygon, segment_to_polygon
from jtik.geometry.scene import Scene
from jtik.geometry.segments import closest_points, segment_distances, segment_to_segment
from jtik.geometry.slots import ABSENT, Slot, Slots
from jtik.geometry.solids import Ball, Box, Capsule, Circle, Cylinder, Point, Solid, Sphere
from jtik.geometry.witness import Witness, witness

__all__ = [
    "ABSENT",
    "Axis",
    "Ball",
    "Box",
    "Capsule",
    "Circle",
    "Cylinder",
    "Distances",
    "HalfSpace",
    "Obstacle",
    "Point",
    "Polygon",
    "Scene",
    "Sides",
    "Slot",
    "Slots",
    "Solid",
    "Sphere",
    "Witness",
    "bounds",
    "centers_and_radii",
    "closest_points",
    "enclosing_balls",
    "enclosing_segment",
    "in_axes",
    "point_to_ball",
    "point_to_box",
    "point_to_capsule",
    "point_to_cylinder",
    "point_to_half_space",
    "point_to_polygon",
    "segment_distances",
    "segment_to_ball",
    "segment_to_box",
    "segment_to_capsule",
    "segment_to_cylinder",
    "segment_to_half_space",
    "segment_to_polygon",
    "segment_to_segment",
    "witness",
]
