"""Kinematic models: joints and frames, in numbers and in symbols."""

from jtik.robot.body import Mass
from jtik.robot.dh import DHRow
from jtik.robot.joints import JointType
from jtik.robot.kinematics import Kinematics
from jtik.robot.model import Robot
from jtik.robot.tree import Joint, Mimic

__all__ = ["DHRow", "Joint", "JointType", "Kinematics", "Mass", "Mimic", "Robot"]
