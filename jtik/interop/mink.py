"""Conversion between jtik and mink: criteria as mink tasks, mink tasks and limits for jtik, robots as MuJoCo models.

mink minimises over the displacement dq of a step; its limits are ``G dq <= h``. Pass arguments to its functions by
keyword: ``limits`` has the position of pink's ``barriers``, and None means "position limits only".
"""

from __future__ import annotations

from typing import Any, cast

import mink
import numpy as np
from mink.tasks import BaseTask, Objective

from jtik.criterion.base import Criterion, CriterionSum
from jtik.errors import ArgumentError
from jtik.interop.criterion_evaluation import CriterionNumbers, Curvature, checked
from jtik.interop.limit_rows import Inequality, LimitRows
from jtik.interop.mujoco_model import MujocoCorrespondence, to_mujoco
from jtik.interop.renamed import renamed_classes
from jtik.robot import Robot
from jtik.types import Array

__all__ = [
    "LimitRows",
    "MinkCriterionTask",
    "MinkTaskCriterion",
    "MujocoCorrespondence",
    "as_criterion",
    "criterion_task",
    "limit_rows",
    "to_mujoco",
    "velocity_limit",
]


class MinkCriterionTask(BaseTask):
    """A jtik criterion as a mink task, made by `criterion_task`.

    Next to other tasks it is weighted against them; with the tasks as ``constraints`` it has strictly lower priority.
    Its objective is 1/2 dq' P dq + gain dH' dq. With P the identity the strict form is Newton's step with the
    null-space projection; alternatively P is the convex part of gain times the Hessian.

    Args:
        criterion: a criterion or a weighted sum.
        robot: the jtik robot of the model.
        model: the ``mujoco.MjModel`` of the configurations.

    Attributes:
        parameters: live parameters of the criterion by name.
        gain: beta, the factor of the gradient.
        curvature: "identity" or "convex", the choice of P.
    """

    def __init__(
        self, criterion: Criterion | CriterionSum, robot: Robot, model: Any, *, gain: float, curvature: Curvature
    ) -> None:
        checked(gain, curvature)
        self.gain, self.curvature = float(gain), curvature
        self._numbers = CriterionNumbers(criterion, robot)
        self._correspondence = MujocoCorrespondence(robot, model)
        self.parameters = self._numbers.parameters

    def value(self, configuration: mink.Configuration) -> float:
        """H at a mink configuration; ``Objective.value`` of mink 1.3 omits the factor 1/2 of the quadratic part.

        Args:
            configuration: the configuration, of the same model.
        """
        return self._numbers.value(self._correspondence.q(configuration.q))

    def compute_qp_objective(self, configuration: mink.Configuration) -> Objective:
        """(P, gain dH) in the velocities of the model; entries of joints that the robot does not have are zero.

        Args:
            configuration: the configuration, of the same model.
        """
        P, c = self._numbers.objective(self._correspondence.q(configuration.q), self.gain, self.curvature)
        leads = self._correspondence.leads
        return Objective(leads @ P @ leads.T, leads @ c)


def criterion_task(
    criterion: Criterion | CriterionSum,
    robot: Robot,
    model: Any,
    *,
    gain: float = 1.0,
    curvature: Curvature = "identity",
) -> MinkCriterionTask:
    """A criterion as a task for ``mink.solve_ik(tasks=[...])`` on ``model``.

    Args:
        criterion: a criterion or a weighted sum.
        robot: the robot of the criterion, with all or some of the joints of the model.
        model: the ``mujoco.MjModel``: the one the robot was read from, or `to_mujoco` of it.
        gain: beta, the factor of the gradient of H.
        curvature: "identity", or "convex" for the Hessian of H without its negative part.

    Raises:
        ArgumentError: when the gain is not positive, or the model does not have a joint of the robot.
    """
    return MinkCriterionTask(criterion, robot, model, gain=gain, curvature=curvature)


class MinkTaskCriterion:
    """H = 1/2 e' W^2 e of a mink task, evaluated on a jtik robot; made by `as_criterion`.

    Args:
        task: the mink task.
        robot: the jtik robot of the model.
        model: the ``mujoco.MjModel`` of the task.
    """

    def __init__(self, task: BaseTask, robot: Robot, model: Any) -> None:
        if not isinstance(task, BaseTask):
            raise ArgumentError("task", task, "a mink task")
        self._task, self._robot = task, robot
        self._correspondence = MujocoCorrespondence(robot, model)
        self._configuration = mink.Configuration(model)

    def value(self, q: Any) -> float:
        """H at q (nq,); 0 for a task without an error, which has an objective only.

        Args:
            q: configuration of the jtik robot (nq,) [rad] or [m].
        """
        self._at(q)
        if not isinstance(self._task, mink.Task):
            return 0.0
        weighted = self._task.cost * self._task.compute_error(self._configuration)
        return float(weighted @ weighted) / 2

    def gradient(self, q: Any) -> Array:
        """dH/dv = J' W^2 e, (n,); without an error the linear part of the objective.

        Args:
            q: configuration of the jtik robot (nq,) [rad] or [m].
        """
        return self._objective(q)[1]

    def hessian(self, q: Any) -> Array:
        """The Gauss-Newton Hessian J' W^2 J, (n, n); without an error the quadratic part of the objective.

        Args:
            q: configuration of the jtik robot (nq,) [rad] or [m].
        """
        return self._objective(q)[0]

    def _at(self, q: Any) -> None:
        # at every call: the target may have changed at the same q
        self._configuration.update(self._correspondence.qpos(self._robot.configuration(q)))

    def _objective(self, q: Any) -> tuple[Array, Array]:
        self._at(q)
        moves = self._correspondence.moves
        if isinstance(self._task, mink.Task):  # without gain and damping, which belong to the step, not to H
            J = self._task.cost[:, None] * (self._task.compute_jacobian(self._configuration) @ moves)
            e = self._task.cost * self._task.compute_error(self._configuration)
            return J.T @ J, J.T @ e
        P, c = self._task.compute_qp_objective(self._configuration)
        return moves.T @ P @ moves, moves.T @ c


def as_criterion(task: BaseTask, robot: Robot, model: Any) -> MinkTaskCriterion:
    """The function of q that a mink task minimises, with its gradient and Gauss-Newton Hessian.

    It is evaluated in Python and is not an expression; use it for comparisons and checks. To solve with a mink task
    pass it to ``strategy=Mink(tasks=[task])``.

    Args:
        task: the task, with its target set; a later change of the target has effect at once.
        robot: the robot.
        model: the ``mujoco.MjModel`` of the task.

    Raises:
        ArgumentError: when it is not a mink task, or the model does not have a joint of the robot.
    """
    return MinkTaskCriterion(task, robot, model)


class MinkRows(LimitRows):
    """A mink limit on the displacement dq of a jtik robot; made by `limit_rows`."""

    library = "mink"

    def __init__(self, limit: mink.Limit, robot: Robot, model: Any, dt: float) -> None:
        if not isinstance(limit, mink.Limit):
            raise ArgumentError("limit", limit, "a mink.Limit")
        super().__init__(robot, dt)
        self._limit = limit
        # h of this limit is a speed in place of a displacement; at 1 s both are the same number
        self._dt = 1.0 if isinstance(limit, mink.CollisionAvoidanceLimit) else float(dt)
        self._correspondence = MujocoCorrespondence(robot, model)
        self._configuration = mink.Configuration(model)

    def _all(self, q: Array) -> Inequality:
        self._configuration.update(self._correspondence.qpos(q))
        found = self._limit.compute_qp_inequalities(self._configuration, self._dt)
        if found.inactive:
            return Inequality(np.zeros((0, self._robot.n)), np.zeros(0))
        return Inequality(cast(Array, found.G) @ self._correspondence.moves, np.array(found.h, dtype=float))


def limit_rows(limit: mink.Limit, robot: Robot, model: Any, *, dt: float = 1.0) -> LimitRows:
    """A mink limit as ``G dq <= h`` on displacements of the robot.

    `mink.CollisionAvoidanceLimit` bounds a displacement by gain (d - d_min) / dt, which is too large by 1 / dt; here
    the bound is gain (d - d_min) for every dt.

    Args:
        limit: the limit.
        robot: the robot.
        model: the ``mujoco.MjModel`` of the limit.
        dt: duration of a step [s], for velocity limits.

    Raises:
        ArgumentError: when it is not a mink limit, dt is not positive, or the model does not have a joint of the robot.
    """
    return MinkRows(limit, robot, model, dt)


def velocity_limit(robot: Robot, model: Any) -> mink.VelocityLimit:
    """The finite velocity limits of the robot as a mink limit; a MuJoCo model has no velocity limits.

    Args:
        robot: the jtik robot of the model.
        model: the ``mujoco.MjModel`` of the limit.
    """
    finite = {
        joint.name: np.full(joint.type.nv, joint.velocity_limit)
        for joint in robot.independent_joints
        if np.isfinite(joint.velocity_limit)
    }
    return mink.VelocityLimit(model, finite)


__getattr__ = renamed_classes(
    __name__,
    {"Correspondence": MujocoCorrespondence, "CriterionTask": MinkCriterionTask, "TaskCriterion": MinkTaskCriterion},
)
