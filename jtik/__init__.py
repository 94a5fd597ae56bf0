"""jtik: redundancy resolution by any update law, with any criterion, in one fused compiled step."""

from jtik import problems
from jtik.constraints.clearance import Clearance
from jtik.constraints.limits import Limits
from jtik.criterion.base import Criterion, CriterionError, CriterionSum, criterion
from jtik.errors import ArgumentError, JtikError, MissingExtraError, RobotFileError, UnknownNameError
from jtik.geometry import Box, Capsule, Circle, Cylinder, Point, Sphere
from jtik.registry import (
    PluginError,
    criteria,
    register_criterion,
    register_secondary,
    register_strategy,
    secondaries,
    strategies,
)
from jtik.result.batch import SolutionBatch
from jtik.result.relaxation import Relaxation
from jtik.result.solution import Solution, Status, Step, Trace
from jtik.result.trajectory import Trajectory
from jtik.robot import Joint, JointType, Robot
from jtik.solver import InverseKinematics
from jtik.strategy import Strategy
from jtik.study import Comparison, compare
from jtik.task import AxisTask, CenterOfMassTask, FrameTask, LookAtTask, RelativeFrameTask, Task

__version__ = "0.1.0"

__all__ = [
    "ArgumentError",
    "AxisTask",
    "Box",
    "Capsule",
    "CenterOfMassTask",
    "Circle",
    "Clearance",
    "Comparison",
    "Criterion",
    "CriterionError",
    "CriterionSum",
    "Cylinder",
    "FrameTask",
    "InverseKinematics",
    "Joint",
    "JointType",
    "JtikError",
    "Limits",
    "LookAtTask",
    "MissingExtraError",
    "PluginError",
    "Point",
    "RelativeFrameTask",
    "Relaxation",
    "Robot",
    "RobotFileError",
    "Solution",
    "SolutionBatch",
    "Sphere",
    "Status",
    "Step",
    "Strategy",
    "Task",
    "Trace",
    "Trajectory",
    "UnknownNameError",
    "compare",
    "criteria",
    "criterion",
    "problems",
    "register_criterion",
    "register_secondary",
    "register_strategy",
    "secondaries",
    "strategies",
]
