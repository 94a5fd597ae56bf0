"""Kinematic models: joints and frames, in numbers and in symbols."""

from jtik.robot.collisions import CollisionBody, CollisionPair, CollisionPairs
from jtik.robot.dh import DHRow
from jtik.robot.joint_type import JointType
from jtik.robot.joint_weights import UNWEIGHTED, WeightedCoordinates
from jtik.robot.kinematics import Kinematics
from jtik.robot.masses_and_shapes import Mass
from jtik.robot.mesh import Mesh
from jtik.robot.model import Robot
from jtik.robot.tree import Joint, Mimic

__all__ = [
    "UNWEIGHTED",
    "CollisionBody",
    "CollisionPair",
    "CollisionPairs",
    "DHRow",
    "Joint",
    "JointType",
    "Kinematics",
    "Mass",
    "Mesh",
    "Mimic",
    "Robot",
    "WeightedCoordinates",
]
