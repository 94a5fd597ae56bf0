"""Solids in the workspace and on the links of a robot, and signed distances to them as CasADi expressions."""

from jtik.geometry.distances import point_to_ball, segment_to_ball
from jtik.geometry.obstacles import Obstacle, centers_and_radii
from jtik.geometry.segments import closest_points, segment_distances, segment_to_segment
from jtik.geometry.solids import Ball, Box, Capsule, Circle, Cylinder, Point, Solid, Sphere, enclosing_segment

__all__ = [
    "Ball",
    "Box",
    "Capsule",
    "Circle",
    "Cylinder",
    "Obstacle",
    "Point",
    "Solid",
    "Sphere",
    "centers_and_radii",
    "closest_points",
    "enclosing_segment",
    "point_to_ball",
    "segment_distances",
    "segment_to_ball",
    "segment_to_segment",
]
