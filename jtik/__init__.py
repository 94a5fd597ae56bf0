"""Redundancy resolution: inverse kinematics with a criterion for the redundant degrees of freedom.

`InverseKinematics` solves; a robot, a task, criteria and a strategy are its arguments; it returns a `Solution`.

Three mappings list what is registered, and each shows itself as a table: ``jtik.strategies``, ``jtik.criteria`` and
``jtik.secondaries`` (null-space terms, for pairs such as ``strategy="newton+qp"``). `register_strategy`,
`register_criterion` and `register_secondary` add to them.

What is in ``jtik`` itself is public, and so are these modules:

- `jtik.robot`: kinematic models, their builders and loaders.
- `jtik.task`: errors of frames, axes, the centre of mass.
- `jtik.criterion`: criteria, sums of them, live parameters.
- `jtik.constraints`: limits and clearances.
- `jtik.strategy`: what a strategy is made of.
- `jtik.qp`: quadratic programs and their solvers.
- `jtik.symbolic`: the mathematics that criteria and strategies are written in.
- `jtik.result`: what a solver returns.
- `jtik.geometry`: obstacles and other shapes.
- `jtik.study`: comparisons of strategies.
- `jtik.problems`: generators and collections of problems.
- `jtik.plotting`: pictures of robots.
- `jtik.viewer`: what `view` shows in a browser.
- `jtik.interop`: mink, pink, MuJoCo, Pinocchio.
- `jtik.testing`: the contract that every strategy and criterion must pass.
- `jtik.registry`, `jtik.errors`, `jtik.types`, `jtik.progress`: names to classes, errors, array types, progress.

A module, a class or a function whose name begins with an underscore is private and may change in any release.
The module `jtik.criterion` is imported as ``from jtik.criterion import ...``,
because ``jtik.criterion`` is the decorator.
"""

from __future__ import annotations

import importlib
import warnings
from typing import TYPE_CHECKING, Any

from jtik.criterion import Criterion, CriterionError, CriterionSum, criterion
from jtik.errors import ArgumentError, JtikError, MissingExtraError, RobotFileError, UnknownNameError

if TYPE_CHECKING:
    from jtik import interop, planner, plotting, problems, study, testing
    from jtik.constraints import Clearance, Limits
    from jtik.geometry import Box, Capsule, Circle, Cylinder, HalfSpace, Point, Polygon, Scene, Sphere
    from jtik.registry import (
        PluginError,
        citations,
        criteria,
        register_criterion,
        register_secondary,
        register_strategy,
        secondaries,
        strategies,
    )
    from jtik.result import Jog, Relaxation, Solution, SolutionBatch, Status, Step, Trace, Trajectory
    from jtik.robot import Joint, JointType, Robot
    from jtik.solver import InverseKinematics
    from jtik.strategy import Strategy, StrategyError
    from jtik.study.compare import compare
    from jtik.study.comparison import Comparison
    from jtik.task import AxisTask, CenterOfMassTask, FrameTask, LookAtTask, RelativeFrameTask, Task
    from jtik.viewer import view

__version__ = "0.2.0"

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
    "HalfSpace",
    "InverseKinematics",
    "Jog",
    "Joint",
    "JointType",
    "JtikError",
    "Limits",
    "LookAtTask",
    "MissingExtraError",
    "PluginError",
    "Point",
    "Polygon",
    "RelativeFrameTask",
    "Relaxation",
    "Robot",
    "RobotFileError",
    "Scene",
    "Solution",
    "SolutionBatch",
    "Sphere",
    "Status",
    "Step",
    "Strategy",
    "StrategyError",
    "Task",
    "Trace",
    "Trajectory",
    "UnknownNameError",
    "citations",
    "compare",
    "criteria",
    "criterion",
    "interop",
    "planner",
    "plotting",
    "problems",
    "register_criterion",
    "register_secondary",
    "register_strategy",
    "secondaries",
    "strategies",
    "study",
    "testing",
    "view",
]

_MODULES = {
    "constraints": ("Clearance", "Limits"),
    "geometry": ("Box", "Capsule", "Circle", "Cylinder", "HalfSpace", "Point", "Polygon", "Scene", "Sphere"),
    "registry": (
        "PluginError",
        "citations",
        "criteria",
        "register_criterion",
        "register_secondary",
        "register_strategy",
        "secondaries",
        "strategies",
    ),
    "result": ("Jog", "Relaxation", "Solution", "SolutionBatch", "Status", "Step", "Trace", "Trajectory"),
    "robot": ("Joint", "JointType", "Robot"),
    "solver": ("InverseKinematics",),
    "strategy": ("Strategy", "StrategyError"),
    "study.compare": ("compare",),
    "study.comparison": ("Comparison",),
    "task": ("AxisTask", "CenterOfMassTask", "FrameTask", "LookAtTask", "RelativeFrameTask", "Task"),
    "viewer": ("view",),
}
"""Modules that are imported when a name of theirs is first used. Not `jtik.criterion`: its import would hide the
decorator of the same name."""

_LAZY = {name: f"jtik.{module}" for module, names in _MODULES.items() for name in names}

_LAZY_MODULES = (
    "constraints",
    "geometry",
    "interop",
    "planner",
    "plotting",
    "problems",
    "progress",
    "qp",
    "registry",
    "result",
    "robot",
    "solver",
    "strategy",
    "study",
    "task",
    "testing",
    "viewer",
)

_RENAMED = {"GaveWay": "Relaxation"}
"""Former names and the present ones; they go after one release."""

if not TYPE_CHECKING:  # a type checker then still finds misspelled names

    def __getattr__(name: str) -> Any:
        """A name that is imported on first use, or a former name of one."""
        if name in _RENAMED:
            new = _RENAMED[name]
            warnings.warn(f"jtik.{name} is now jtik.{new}", DeprecationWarning, stacklevel=2)
            name = new
        if name in _LAZY_MODULES:
            return importlib.import_module(f"jtik.{name}")
        if name in _LAZY:
            found = globals()[name] = getattr(importlib.import_module(_LAZY[name]), name)
            return found
        raise AttributeError(f"module 'jtik' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *_LAZY, *_LAZY_MODULES})
