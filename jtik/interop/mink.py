"""jtik and mink, both ways: a criterion as a task of mink's, a task or limit of mink's for jtik, robots as its models.

mink minimises over the displacement dq of a step; what it calls a limit is ``G dq <= h``. Pass its functions their
arguments by keyword: ``limits`` stands where pink has ``barriers``, and None means "position limits only", not none.
"""

from __future__ import annotations

from typing import Any, cast

import mink
import numpy as np
from mink.tasks import BaseTask, Objective

from jtik.criterion.base import Criterion, CriterionSum
from jtik.errors import ArgumentError
from jtik.interop.limit_rows import Inequality, LimitRows
from jtik.interop.mujoco_model import Correspondence, to_mujoco
from jtik.interop.numbers import CriterionNumbers, Curvature, checked
from jtik.robot import Robot
from jtik.types import Array

__all__ = [
    "Correspondence",
    "CriterionTask",
    "LimitRows",
    "TaskCriterion",
    "as_criterion",
    "criterion_task",
    "limit_rows",
    "to_mujoco",
    "velocity_limit",
]


class CriterionTask(BaseTask):
    """A jtik criterion as a task of mink's: beside other tasks a weighted one, below ``constraints`` a strict second.

    Its objective is 1/2 dq' P dq + gain dH' dq with P the identity, which makes the strict form Newton's step with
    the null-space projection, or with P the convex part of gain times the Hessian.

    Attributes:
        parameters: live parameters of the criterion by name.
    """

    def __init__(
        self, criterion: Criterion | CriterionSum, robot: Robot, model: Any, *, gain: float, curvature: Curvature
    ) -> None:
        checked(gain, curvature)
        self.gain, self.curvature = float(gain), curvature
        self._numbers = CriterionNumbers(criterion, robot)
        self._places = Correspondence(robot, model)
        self.parameters = self._numbers.parameters

    def value(self, configuration: mink.Configuration) -> float:
        """H at mink's configuration; ``Objective.value`` of mink 1.3 omits the half of its quadratic part."""
        return self._numbers.value(self._places.q(configuration.q))

    def compute_qp_objective(self, configuration: mink.Configuration) -> Objective:
        """(P, gain dH) in the model's velocities; joints the robot lacks are not touched."""
        P, c = self._numbers.objective(self._places.q(configuration.q), self.gain, self.curvature)
        leads = self._places.leads
        return Objective(leads @ P @ leads.T, leads @ c)


def criterion_task(
    criterion: Criterion | CriterionSum,
    robot: Robot,
    model: Any,
    *,
    gain: float = 1.0,
    curvature: Curvature = "identity",
) -> CriterionTask:
    """A criterion as a task for ``mink.solve_ik(tasks=[...])`` on ``model``.

    Args:
        criterion: a criterion or a weighted sum.
        robot: the robot it is about, with the joints of the model or some of them.
        model: the ``mujoco.MjModel``: the one the robot was read from, or `to_mujoco` of it.
        gain: beta, how far down H a step goes.
        curvature: "identity", or "convex" for the Hessian of H without its negative part.

    Raises:
        ArgumentError: when the gain is not positive, or the model lacks a joint of the robot.
    """
    return CriterionTask(criterion, robot, model, gain=gain, curvature=curvature)


class TaskCriterion:
    """H = 1/2 e' W^2 e of a task of mink's, as numbers on a jtik robot; see `as_criterion`."""

    def __init__(self, task: BaseTask, robot: Robot, model: Any) -> None:
        if not isinstance(task, BaseTask):
            raise ArgumentError("task", task, "a mink task")
        self._task, self._robot = task, robot
        self._places = Correspondence(robot, model)
        self._configuration = mink.Configuration(model)

    def value(self, q: Any) -> float:
        """H at q (nq,); of a task that has no error, only an objective, 0."""
        self._at(q)
        if not isinstance(self._task, mink.Task):
            return 0.0
        weighted = self._task.cost * self._task.compute_error(self._configuration)
        return float(weighted @ weighted) / 2

    def gradient(self, q: Any) -> Array:
        """dH/dv = J' W^2 e, (n,); of a task without an error the linear part of its objective."""
        return self._objective(q)[1]

    def hessian(self, q: Any) -> Array:
        """Its Gauss-Newton part J' W^2 J, (n, n); of a task without an error the quadratic part of its objective."""
        return self._objective(q)[0]

    def _at(self, q: Any) -> None:
        # always: a target may have moved while q stood still
        self._configuration.update(self._places.qpos(self._robot.configuration(q)))

    def _objective(self, q: Any) -> tuple[Array, Array]:
        self._at(q)
        moves = self._places.moves
        if isinstance(self._task, mink.Task):  # without gain and damping, which are of the step, not of H
            J = self._task.cost[:, None] * (self._task.compute_jacobian(self._configuration) @ moves)
            e = self._task.cost * self._task.compute_error(self._configuration)
            return J.T @ J, J.T @ e
        P, c = self._task.compute_qp_objective(self._configuration)
        return moves.T @ P @ moves, moves.T @ c


def as_criterion(task: BaseTask, robot: Robot, model: Any) -> TaskCriterion:
    """What a task of mink's minimises, as a function of the robot's q with gradient and Gauss-Newton Hessian.

    It is Python, not an expression: for comparisons and checks. To solve with it give the task itself to
    ``strategy=Mink(tasks=[task])``; a criterion of jtik's own is traced.

    Args:
        task: the task, with its target set; changing that is seen at once.
        robot: the robot.
        model: the ``mujoco.MjModel`` the task is about.

    Raises:
        ArgumentError: when it is no task of mink's, or the model lacks a joint of the robot.
    """
    return TaskCriterion(task, robot, model)


class MinkRows(LimitRows):
    """A limit of mink's on the displacement dq of a jtik robot; see `limit_rows`."""

    library = "mink"

    def __init__(self, limit: mink.Limit, robot: Robot, model: Any, dt: float) -> None:
        if not isinstance(limit, mink.Limit):
            raise ArgumentError("limit", limit, "a mink.Limit")
        super().__init__(robot, dt)
        self._limit = limit
        # h of this one is a speed where a displacement belongs; at 1 s the two are the same number
        self._dt = 1.0 if isinstance(limit, mink.CollisionAvoidanceLimit) else float(dt)
        self._places = Correspondence(robot, model)
        self._configuration = mink.Configuration(model)

    def _all(self, q: Array) -> Inequality:
        self._configuration.update(self._places.qpos(q))
        found = self._limit.compute_qp_inequalities(self._configuration, self._dt)
        if found.inactive:
            return Inequality(np.zeros((0, self._robot.n)), np.zeros(0))
        return Inequality(cast(Array, found.G) @ self._places.moves, np.array(found.h, dtype=float))


def limit_rows(limit: mink.Limit, robot: Robot, model: Any, *, dt: float = 1.0) -> LimitRows:
    """A limit of mink's as ``G dq <= h`` on displacements of the robot.

    `mink.CollisionAvoidanceLimit` bounds a displacement by gain (d - d_min) / dt, too much by 1 / dt; here it is
    gain (d - d_min), whatever dt.

    Args:
        limit: the limit.
        robot: the robot.
        model: the ``mujoco.MjModel`` the limit was made for.
        dt: how long a step takes [s], for velocity limits.

    Raises:
        ArgumentError: when it is no limit of mink's, dt is not positive, or the model lacks a joint of the robot.
    """
    return MinkRows(limit, robot, model, dt)


def velocity_limit(robot: Robot, model: Any) -> mink.VelocityLimit:
    """The robot's velocity limits, those there are, as mink's: a MuJoCo model has none."""
    finite = {
        joint.name: np.full(joint.type.nv, joint.velocity_limit)
        for joint in robot.independent_joints
        if np.isfinite(joint.velocity_limit)
    }
    return mink.VelocityLimit(model, finite)
