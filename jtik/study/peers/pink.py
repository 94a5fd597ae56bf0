"""pink as a contender: one quadratic program for each step, on Pinocchio's kinematics."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from jtik.study.peers.base import Goal, imported
from jtik.study.peers.differential import DifferentialLoop, DifferentialPeer
from jtik.types import Array


@dataclass(kw_only=True)
class PinkPeer(DifferentialPeer):
    """A loop over ``pink.solve_ik`` with a frame task, position limits, and a criterion from `jtik.interop.pink`.

    The defaults are those of mink, which solves the same quadratic program.

    Attributes:
        label: name of the library in a study.
    """

    label: str = "pink"
    module: ClassVar[str] = "pink"
    package: ClassVar[str] = "pin-pink"

    def build(self, library: Any, goal: Goal) -> DifferentialLoop:
        """Build it on the robot as a URDF, which Pinocchio reads."""
        return _PinkLoop(library, goal, self)


class _PinkLoop(DifferentialLoop):
    """The loop of pink."""

    def __init__(self, library: Any, goal: Goal, options: PinkPeer) -> None:
        from jtik.interop.pink import PinocchioCorrespondence, criterion_task
        from jtik.interop.urdf import to_urdf

        super().__init__(library, goal, options, library.exceptions.NoSolutionFound)
        self._pinocchio = imported("pinocchio", options.package)
        model = self._pinocchio.buildModelFromXML(to_urdf(goal.robot))
        self._places = PinocchioCorrespondence(goal.robot, model)
        start = self._places.theirs(goal.robot.neutral)
        self.configuration = library.Configuration(model, model.createData(), start)
        self.task = library.FrameTask(
            goal.frame,
            position_cost=1.0 if goal.has_position else 0.0,
            orientation_cost=options.orientation_cost if goal.has_orientation else 0.0,
            lm_damping=options.lm_damping,
        )
        if goal.setting.limits:
            self._limits.append(library.limits.ConfigurationLimit(model, config_limit_gain=options.limit_gain))
        if goal.setting.criteria is not None:
            self.minimise(criterion_task(goal.setting.criteria, goal.robot, model, curvature="convex"))

    def convert(self, target: Any) -> Any:
        """The target as ``pinocchio.SE3``."""
        return self._pinocchio.SE3(self.goal.pose(target))

    def library_configuration(self, q: Array) -> Array:
        """Configuration as Pinocchio's q."""
        return self._places.theirs(q)

    def q(self) -> Array:
        """Configuration from Pinocchio's q."""
        return self._places.q(self.configuration.q)

    def displacement(self, tasks: list[Any], constraints: list[Any], **more: Any) -> Array | None:
        """As in the base class, but also from a configuration outside the limits."""
        return super().displacement(tasks, constraints, safety_break=False, **more)
