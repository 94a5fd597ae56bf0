"""mink as a contender: one quadratic program for each step, on MuJoCo's kinematics."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from jtik.study.peers.base import Goal
from jtik.study.peers.differential import DifferentialLoop, DifferentialPeer
from jtik.types import Array


@dataclass(kw_only=True)
class MinkPeer(DifferentialPeer):
    """A loop over ``mink.solve_ik`` with a frame task, position limits, and a criterion from `jtik.interop.mink`.

    The defaults are the best of a search over seven arms with restarts: 10 to 25 steps for an attempt, ``lm_damping``
    from 0 to 0.1, orientation costs 1 and 0.25, gains 0.95 and 0.999. All robots and joint types are supported.

    Attributes:
        label: name of the library in a study.
    """

    label: str = "mink"
    module: ClassVar[str] = "mink"
    package: ClassVar[str] = "mink"

    def check(self, goal: Goal) -> None:
        """All robots are supported."""

    def build(self, library: Any, goal: Goal) -> DifferentialLoop:
        """Build it on the robot as a MuJoCo model."""
        return _MinkLoop(library, goal, self)


class _MinkLoop(DifferentialLoop):
    """The loop of mink."""

    def __init__(self, library: Any, goal: Goal, options: MinkPeer) -> None:
        from jtik.interop.mink import criterion_task
        from jtik.interop.mujoco_model import MujocoCorrespondence, to_mujoco

        super().__init__(library, goal, options, library.NoSolutionFound)
        model = to_mujoco(goal.robot)
        self._places = MujocoCorrespondence(goal.robot, model)
        self.configuration = library.Configuration(model)
        self.task = library.FrameTask(
            goal.frame,
            "body",
            position_cost=1.0 if goal.has_position else 0.0,
            orientation_cost=options.orientation_cost if goal.has_orientation else 0.0,
            lm_damping=options.lm_damping,
        )
        if goal.setting.limits:
            self._limits.append(library.ConfigurationLimit(model, gain=options.limit_gain))
        if goal.setting.criteria is not None:
            self.minimise(criterion_task(goal.setting.criteria, goal.robot, model, curvature="convex"))

    def convert(self, target: Any) -> Any:
        """The target as ``mink.SE3``."""
        return self._library.SE3.from_matrix(self.goal.pose(target))

    def library_configuration(self, q: Array) -> Array:
        """Configuration as the model's qpos."""
        return self._places.qpos(q)

    def q(self) -> Array:
        """Configuration from the model's qpos."""
        return self._places.q(self.configuration.q)
