"""mink: a quadratic program a step on MuJoCo's kinematics."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from jtik.errors import Array
from jtik.study.peers.base import Goal
from jtik.study.peers.differential import Differential, DifferentialLoop


@dataclass(kw_only=True)
class Mink(Differential):
    """A loop round ``mink.solve_ik``: a frame task, position limits, and a criterion as `jtik.interop.mink` gives it.

    Its defaults were found over seven arms with restarts: 10 to 25 steps an attempt, ``lm_damping`` 0 to 0.1,
    orientation at cost 1 and 0.25, gains 0.95 and 0.999. It takes any robot and any kind of joint.
    """

    label: str = "mink"
    module: ClassVar[str] = "mink"
    package: ClassVar[str] = "mink"

    def check(self, goal: Goal) -> None:
        """All robots will do."""

    def build(self, library: Any, goal: Goal) -> DifferentialLoop:
        """On the robot as a MuJoCo model."""
        return _MinkLoop(library, goal, self)


class _MinkLoop(DifferentialLoop):
    """mink at work."""

    def __init__(self, library: Any, goal: Goal, options: Mink) -> None:
        from jtik.interop.mink import criterion_task
        from jtik.interop.mujoco_model import Correspondence, to_mujoco

        super().__init__(goal, restarted=options.restarted)
        model = to_mujoco(goal.robot)
        self._library, self._options = library, options
        self._places = Correspondence(goal.robot, model)
        self.configuration = library.Configuration(model)
        self.task = library.FrameTask(
            goal.frame,
            "body",
            position_cost=1.0 if goal.places else 0.0,
            orientation_cost=options.orientation_cost if goal.turns else 0.0,
            lm_damping=options.lm_damping,
        )
        self._limits = [library.ConfigurationLimit(model, gain=options.limit_gain)] if goal.setting.limits else []
        if goal.setting.criteria is not None:
            self.minimise(criterion_task(goal.setting.criteria, goal.robot, model, curvature="convex"))

    def convert(self, target: Any) -> Any:
        """An ``mink.SE3``."""
        return self._library.SE3.from_matrix(self.goal.pose(target))

    def aim(self, target: Any) -> None:
        """Set the task's target."""
        self.task.set_target(target)

    def theirs(self, q: Array) -> Array:
        """The model's qpos."""
        return self._places.qpos(q)

    def q(self) -> Array:
        """Out of the model's qpos."""
        return self._places.q(self.configuration.q)

    def displacement(self, tasks: list[Any], constraints: list[Any]) -> Array | None:
        """By ``mink.solve_ik``."""
        try:
            dq = self._library.solve_ik(
                configuration=self.configuration,
                tasks=tasks,
                dt=1.0,
                solver=self._options.solver,
                limits=self._limits,
                constraints=constraints or None,
            )
        except self._library.NoSolutionFound:
            return None
        return dq if np.isfinite(dq).all() else None
