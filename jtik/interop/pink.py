"""Conversion between jtik and pink: criteria as pink tasks, pink tasks, limits and barriers for jtik.

pink's functions take their arguments in another order than mink's: pass them by keyword. They raise an error at a start
outside the limits unless they get ``safety_break=False``. A pink task is recognised by its methods, so this module
imports pink only where it makes a configuration.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from jtik.criterion.base import Criterion, CriterionSum
from jtik.errors import ArgumentError, MissingExtraError
from jtik.interop.criterion_evaluation import CriterionNumbers, Curvature, checked
from jtik.interop.limit_rows import Inequality, LimitRows
from jtik.interop.pinocchio_model import PinocchioCorrespondence
from jtik.interop.renamed import renamed_classes
from jtik.robot import Robot
from jtik.types import Array

__all__ = [
    "FreshBarrier",
    "LimitRows",
    "PinkCriterionTask",
    "PinkTaskCriterion",
    "PinocchioCorrespondence",
    "as_criterion",
    "criterion_task",
    "fresh",
    "limit_rows",
]


class PinkCriterionTask:
    """A jtik criterion as a pink task, made by `criterion_task`: pink uses only the objective of a task.

    Args:
        criterion: a criterion or a weighted sum.
        robot: the jtik robot of the model.
        model: the ``pinocchio.Model`` of the configurations.

    Attributes:
        parameters: live parameters of the criterion by name.
        gain: beta, the factor of the gradient.
        curvature: "identity" or "convex", the quadratic part of the objective.
    """

    def __init__(
        self, criterion: Criterion | CriterionSum, robot: Robot, model: Any, *, gain: float, curvature: Curvature
    ) -> None:
        checked(gain, curvature)
        self.gain, self.curvature = float(gain), curvature
        self._numbers = CriterionNumbers(criterion, robot)
        self._correspondence = PinocchioCorrespondence(robot, model)
        self.parameters = self._numbers.parameters

    def __repr__(self) -> str:
        return f"PinkCriterionTask({', '.join(self.parameters)}, gain={self.gain:g})"

    def value(self, configuration: Any) -> float:
        """H at a pink configuration.

        Args:
            configuration: the configuration, of the same model.
        """
        return self._numbers.value(self._correspondence.q(configuration.q))

    def compute_qp_objective(self, configuration: Any) -> tuple[Array, Array]:
        """(P, gain dH) in the velocities of Pinocchio; entries of joints that the robot does not have are zero.

        Args:
            configuration: the configuration, of the same model.
        """
        q = self._correspondence.q(configuration.q)
        P, c = self._numbers.objective(q, self.gain, self.curvature)
        moves = self._correspondence.moves(q)  # orthonormal columns: its transpose is its inverse
        return moves @ P @ moves.T, moves @ c


def criterion_task(
    criterion: Criterion | CriterionSum,
    robot: Robot,
    model: Any,
    *,
    gain: float = 1.0,
    curvature: Curvature = "identity",
) -> PinkCriterionTask:
    """A criterion as a task for ``pink.solve_ik(tasks=[...])``.

    Args:
        criterion: a criterion or a weighted sum.
        robot: the robot of the criterion, with all or some of the joints of the model.
        model: the ``pinocchio.Model``.
        gain: beta, the factor of the gradient of H.
        curvature: "identity", or "convex" for the Hessian of H without its negative part.

    Raises:
        ArgumentError: when the gain is not positive, or the model does not have a joint of the robot.
    """
    return PinkCriterionTask(criterion, robot, model, gain=gain, curvature=curvature)


class PinkTaskCriterion:
    """H = 1/2 e' W^2 e of a pink task, evaluated on a jtik robot; made by `as_criterion`.

    Args:
        task: the pink task.
        robot: the jtik robot of the model.
        model: the ``pinocchio.Model`` of the task.
    """

    def __init__(self, task: Any, robot: Robot, model: Any) -> None:
        if not (hasattr(task, "compute_error") and hasattr(task, "compute_jacobian")):
            raise ArgumentError("task", task, "a pink task, with an error and a Jacobian")
        self._task, self._robot = task, robot
        self._correspondence = PinocchioCorrespondence(robot, model)
        self._configuration = _configuration(model, self._correspondence.theirs(robot.neutral))

    def value(self, q: Any) -> float:
        """H at q (nq,).

        Args:
            q: configuration of the jtik robot (nq,) [rad] or [m].
        """
        e, _ = self._weighted(q)
        return float(e @ e) / 2

    def gradient(self, q: Any) -> Array:
        """dH/dv = J' W^2 e, (n,).

        Args:
            q: configuration of the jtik robot (nq,) [rad] or [m].
        """
        e, J = self._weighted(q)
        return J.T @ e

    def hessian(self, q: Any) -> Array:
        """The Gauss-Newton Hessian J' W^2 J, (n, n).

        Args:
            q: configuration of the jtik robot (nq,) [rad] or [m].
        """
        _, J = self._weighted(q)
        return J.T @ J

    def _weighted(self, q: Any) -> tuple[Array, Array]:
        at = self._robot.configuration(q)
        self._configuration.update(self._correspondence.theirs(at))
        e = np.asarray(self._task.compute_error(self._configuration), dtype=float)
        J = np.asarray(self._task.compute_jacobian(self._configuration), dtype=float) @ self._correspondence.moves(at)
        cost = np.ones(len(e)) if self._task.cost is None else np.broadcast_to(self._task.cost, len(e))
        return cost * e, cost[:, None] * J


def as_criterion(task: Any, robot: Robot, model: Any) -> PinkTaskCriterion:
    """The function of q that a pink task minimises, with its gradient and Gauss-Newton Hessian.

    It is evaluated in Python and is not an expression; use it for comparisons and checks.

    Args:
        task: the task, with its target set; a later change of the target has effect at once.
        robot: the robot.
        model: the ``pinocchio.Model``.

    Raises:
        ArgumentError: when it is not a pink task, or the model does not have a joint of the robot.
        MissingExtraError: when pink is not installed.
    """
    return PinkTaskCriterion(task, robot, model)


class FreshBarrier:
    """A pink barrier that is evaluated at every call; made by `fresh`.

    Args:
        barrier: the pink barrier.
    """

    def __init__(self, barrier: Any) -> None:
        if not (hasattr(barrier, "compute_barrier") and hasattr(barrier, "compute_jacobian")):
            raise ArgumentError("barrier", barrier, "a pink barrier")
        self.barrier = barrier

    def __repr__(self) -> str:
        return f"FreshBarrier({self.barrier!r})"

    def compute_qp_objective(self, configuration: Any) -> tuple[Array, Array]:
        """The cost of the distance to the safe displacement: (P, c) in the velocities of Pinocchio.

        Args:
            configuration: the pink configuration.
        """
        barrier, nv = self.barrier, configuration.model.nv
        if not barrier.safe_displacement_gain > 1e-6:
            return np.zeros((nv, nv)), np.zeros(nv)
        J = np.asarray(barrier.compute_jacobian(configuration))
        weight = barrier.safe_displacement_gain / max(float((J * J).sum()), 1e-12)
        return weight * np.eye(nv), -weight * np.asarray(barrier.compute_safe_displacement(configuration))

    def compute_qp_inequalities(self, configuration: Any, dt: float = 1e-3) -> tuple[Array, Array]:
        """The inequality -J dq / dt <= gain g(h).

        Args:
            configuration: the pink configuration.
            dt: duration of a step [s].
        """
        barrier = self.barrier
        # the Jacobian first, as in pink: some barriers cache what both need
        J = np.asarray(barrier.compute_jacobian(configuration), dtype=float)
        h = np.asarray(barrier.compute_barrier(configuration), dtype=float)
        shaped = np.array([barrier.gain_function(value) for value in h])
        return -J / dt, np.broadcast_to(barrier.gain, len(h)) * shaped


def fresh(barrier: Any) -> FreshBarrier:
    """A pink barrier that is evaluated at every call, for ``pink.solve_ik(barriers=[...])``.

    pink 4 keeps the value and the Jacobian of a barrier while q is nearly constant, so a change of an obstacle or of a
    bound has no effect while the robot does not move.

    Args:
        barrier: the pink barrier.

    Raises:
        ArgumentError: when it is not a pink barrier.
    """
    return FreshBarrier(barrier)


class PinkRows(LimitRows):
    """A pink limit or barrier on the displacement dq of a jtik robot; made by `limit_rows`."""

    library = "pink"

    def __init__(self, limit: Any, robot: Robot, model: Any, dt: float) -> None:
        if hasattr(limit, "compute_barrier"):
            limit = FreshBarrier(limit)
        if not hasattr(limit, "compute_qp_inequalities"):
            raise ArgumentError("limit", limit, "a pink limit or barrier")
        super().__init__(robot, dt)
        self._limit, self._dt = limit, float(dt)
        self._correspondence = PinocchioCorrespondence(robot, model)
        self._configuration = _configuration(model, self._correspondence.theirs(robot.neutral))

    def _all(self, q: Array) -> Inequality:
        self._configuration.update(self._correspondence.theirs(q))
        found = self._limit.compute_qp_inequalities(self._configuration, self._dt)
        if found is None:
            return Inequality(np.zeros((0, self._robot.n)), np.zeros(0))
        G, h = np.asarray(found[0], dtype=float), np.asarray(found[1], dtype=float)
        scale = self._dt if isinstance(self._limit, FreshBarrier) else 1.0  # the rows of a barrier are on dq / dt
        return Inequality(scale * (G @ self._correspondence.moves(q)), scale * h)


def limit_rows(limit: Any, robot: Robot, model: Any, *, dt: float = 1.0) -> LimitRows:
    """A pink limit or barrier as ``G dq <= h`` on displacements of the robot.

    Args:
        limit: the limit or the barrier; a barrier is evaluated at every call, see `fresh`.
        robot: the robot.
        model: the ``pinocchio.Model``.
        dt: duration of a step [s].

    Raises:
        ArgumentError: when it is neither, dt is not positive, or the model does not have a joint of the robot.
        MissingExtraError: when pink is not installed.
    """
    return PinkRows(limit, robot, model, dt)


def _configuration(model: Any, q: Array) -> Any:
    try:
        import pink
    except ImportError as error:
        raise MissingExtraError("pink", "pink", "a pink task or limit") from error
    return pink.Configuration(model, model.createData(), q)


__getattr__ = renamed_classes(
    __name__,
    {"Correspondence": PinocchioCorrespondence, "CriterionTask": PinkCriterionTask, "TaskCriterion": PinkTaskCriterion},
)
