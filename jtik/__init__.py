"""jtik: redundancy resolution by any update law, with any criterion, in one fused compiled step."""

from jtik.criterion import Criterion, CriterionError, CriterionSum, criterion
from jtik.errors import ArgumentError, JtikError, MissingExtraError, RobotFileError, UnknownNameError
from jtik.geometry import Box, Capsule, Circle, Cylinder, Point, Sphere
from jtik.registry import (
    PluginError,
    criteria,
    register_criterion,
    register_strategy,
    strategies,
)
from jtik.robot import Joint, JointType, Robot
from jtik.solution import Solution, Status, Step, Trace, Trajectory
from jtik.solver import InverseKinematics
from jtik.strategy import Strategy
from jtik.task import FrameTask, Task

__version__ = "0.1.0"

__all__ = [
    "ArgumentError",
    "Box",
    "Capsule",
    "Circle",
    "Criterion",
    "CriterionError",
    "CriterionSum",
    "Cylinder",
    "FrameTask",
    "InverseKinematics",
    "Joint",
    "JointType",
    "JtikError",
    "MissingExtraError",
    "PluginError",
    "Point",
    "Robot",
    "RobotFileError",
    "Solution",
    "Sphere",
    "Status",
    "Step",
    "Strategy",
    "Task",
    "Trace",
    "Trajectory",
    "UnknownNameError",
    "criteria",
    "criterion",
    "register_criterion",
    "register_strategy",
    "strategies",
]
