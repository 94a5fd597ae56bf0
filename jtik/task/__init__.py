"""Tasks: what the robot must do, as errors in [m] and [rad]."""

from jtik.task.axis import AxisTask
from jtik.task.base import Task, TaskRows
from jtik.task.center_of_mass import CenterOfMassTask
from jtik.task.frame import FrameTask
from jtik.task.look_at import LookAtTask
from jtik.task.placement import PlacementTask
from jtik.task.pointing import PointingTask
from jtik.task.relative import RelativeFrameTask
from jtik.task.stack import TaskStack
from jtik.task.targets import Kind

__all__ = [
    "AxisTask",
    "CenterOfMassTask",
    "FrameTask",
    "Kind",
    "LookAtTask",
    "PlacementTask",
    "PointingTask",
    "RelativeFrameTask",
    "Task",
    "TaskRows",
    "TaskStack",
]
