"""A step's quadratic program as mink builds and solves it: the Python computation of the strategy "mink"."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import mink
import numpy as np
import qpsolvers
from mink.tasks import BaseTask, Objective

from jtik import FrameTask, Robot
from jtik.errors import ArgumentError
from jtik.interop.mink import MujocoCorrespondence, to_mujoco
from jtik.task import Task, TaskStack
from jtik.types import Array

if TYPE_CHECKING:
    from jtik_formulations.strategies.mink_ik import Mink


_EXACT: dict[str, dict[str, Any]] = {
    "daqp": {"primal_tol": 1e-9},
    "osqp": {"eps_abs": 1e-9, "eps_rel": 1e-9, "max_iter": 20000, "polishing": True},
}
"""Options of solvers whose default tolerance is coarser than that of a solve."""

_EQUALITY_TOLERANCE = 1e-6
"""Largest accepted violation of an equality, relative to 1 + the error."""


LEFT = 1e-3
"""Curvature relative to |J|^2 / n above which the target is out of reach for the strict form."""


class MinkStep:
    """A problem of mink, updated with the numbers of each step."""

    def __init__(
        self,
        strategy: Mink,
        robot: Robot,
        stack: TaskStack,
        *,
        strict_rows: Sequence[int],
        solver: str,
        has_criterion: bool,
        weights: Array | None = None,
        own_error: bool = True,
    ) -> None:
        if solver not in qpsolvers.available_solvers:
            names = ", ".join(qpsolvers.available_solvers)
            more = "more come with: pip install 'qpsolvers[open-source-solvers]'"
            raise ArgumentError("solver", solver, f"one that mink can use: {names}; {more}")
        self._curvature, self._own_error = 0.0, own_error
        mujoco_model = to_mujoco(robot)
        mujoco_model.jnt_limited[:] = 0  # the box contains the limits
        self._strategy, self._solver, self._robot = strategy, solver, robot
        self._places = MujocoCorrespondence(robot, mujoco_model)
        self._configuration = mink.Configuration(mujoco_model)
        metric = np.eye(mujoco_model.nv)
        self._back = _Quadratic(0 * metric)  # of motion along weak directions, with limits of acceleration
        self._excess: Array | None = None  # of the metric of the joint weights over mink's
        if weights is not None:
            self._excess = self._places.leads @ np.diag(weights - 1) @ self._places.leads.T
            metric = metric + self._excess
        self._criterion = _Quadratic(metric) if has_criterion else None
        self._lower_tasks: list[BaseTask] = [*strategy.tasks, *([self._criterion] if self._criterion else [])]
        self._box = _BoxLimit(self._places)
        self._followers = [_Rows(self._places.follows)] if len(self._places.follows) else []
        self._parts: list[_TaskPart] = []
        first, start = 0, 0
        for task in stack.tasks:
            last, stop = first + task.row_count(robot), start + task.target_size(robot)
            rows, numbers = slice(first, last), slice(start, stop)
            self._parts.append(
                _TaskPart.of(
                    task,
                    robot,
                    strategy,
                    rows,
                    numbers,
                    self._places,
                    strict=first in strict_rows,
                    own_error=own_error,
                )
            )
            first, start = last, stop

    def __call__(self, numbers: Sequence[Array]) -> Sequence[Any] | None:
        """Displacement (n,), and 1 if the strict form was solved, else 0; None where mink solves neither form."""
        q, target, residual, columns, gradient, low, high, curvature, back = numbers
        self._configuration.update(self._places.qpos(q))
        J = columns.reshape(self._robot.n, -1).T
        for part in self._parts:
            part.read(target, residual, J)
        if self._criterion:
            self._criterion.gradient = self._places.leads @ gradient
        self._box.low, self._box.high = low, high
        self._curvature = float(curvature[0])
        self._back.gradient = self._places.leads @ back
        reached = self._curvature <= LEFT * float((columns**2).sum()) / self._robot.n
        strict = self._solved(strict=True) if self._strategy.strict and reached else None
        if strict is not None:
            return strict, 1.0
        soft = self._solved(strict=False)
        return None if soft is None else (soft, 0.0)

    def _solved(self, *, strict: bool) -> Array | None:
        strategy = self._strategy
        equal = [part.task for part in self._parts if strict and part.strict]
        soft = [part.task for part in self._parts if not (strict and part.strict)]
        weight = strategy.weight if soft else 1.0
        tasks: list[BaseTask] = [*soft, *[_WeightedTask(task, weight) for task in self._lower_tasks]]
        damping = strategy.damping + self._curvature if tasks else 1.0
        if soft and not self._own_error:
            tasks.append(self._back)
        if self._excess is not None:
            size = damping + sum(_error_damping(task, self._configuration) for task in soft)
            tasks.append(_Quadratic(size * self._excess))
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # about solver interfaces, which the caller cannot change
                dq = mink.solve_ik(
                    configuration=self._configuration,
                    tasks=tasks,
                    dt=1.0,  # so that the velocity is the displacement
                    solver=self._solver,
                    damping=damping,
                    limits=[self._box],
                    constraints=[*equal, *self._followers],
                    **_EXACT.get(self._solver, {}),
                )
        except (mink.NoSolutionFound, qpsolvers.exceptions.QPError, ValueError, ArithmeticError, RuntimeError):
            return None
        return self._places.velocity(dq) if self._holds(dq, equal) else None

    def _holds(self, dq: Array, equal: Sequence[mink.Task]) -> bool:
        """Whether the equalities hold; some solvers report success without a solution."""
        for task in equal:
            error = task.gain * task.compute_error(self._configuration)
            violation = task.compute_jacobian(self._configuration) @ dq + error
            if not np.abs(violation).max() <= _EQUALITY_TOLERANCE * (1 + np.abs(error).max()):
                return False
        return bool(np.isfinite(dq).all())


@dataclass(frozen=True)
class _TaskPart:
    """A task of jtik as a task of mink.

    Attributes:
        task: the task of mink.
        strict: whether it is an equality in the strict form.
        rows: its rows in the residual and the Jacobian.
        numbers: its numbers in the target.
        planar: whether the robot is planar.
        places: maps between the coordinates of jtik and of MuJoCo.
    """

    task: mink.FrameTask | _Rows
    strict: bool
    rows: slice
    numbers: slice
    planar: bool
    places: MujocoCorrespondence

    @classmethod
    def of(
        cls,
        task: Task,
        robot: Robot,
        strategy: Mink,
        rows: slice,
        numbers: slice,
        places: MujocoCorrespondence,
        *,
        strict: bool,
        own_error: bool,
    ) -> _TaskPart:
        """mink's FrameTask for a pose with one stiffness of lengths and one of angles; else residual and Jacobian.

        Without ``own_error`` it is the latter for every task.
        """
        planar = robot.dimension == 2
        weight = np.sqrt(np.diag(task.weight(rows.stop - rows.start)))
        made: mink.FrameTask | _Rows = _Rows(np.zeros((rows.stop - rows.start, len(places.leads))))
        if own_error and type(task) is FrameTask and task.kind == "pose" and task.axes is None and not planar:
            Kp = task.weight(6)
            if np.array_equal(Kp, np.diag([Kp[0, 0]] * 3 + [Kp[3, 3]] * 3)):
                costs = {"position_cost": weight[0], "orientation_cost": weight[3]}
                made = mink.FrameTask(frame_name=robot.frame(task.frame), frame_type="body", **costs)
        made.gain, made.lm_damping = strategy.gain, strategy.lm_damping
        return cls(made, strict, rows, numbers, planar, places)

    def read(self, target: Array, residual: Array, J: Array) -> None:
        """Update the task with the numbers of a step."""
        if isinstance(self.task, mink.FrameTask):
            values, pose = target[self.numbers], np.eye(4)
            pose[:3, 3], pose[:3, :3] = values[:3], values[3:].reshape(3, 3).T
            self.task.set_target(mink.SE3.from_matrix(pose))
        else:
            self.task.error = residual[self.rows]
            self.task.jacobian = J[self.rows] @ self.places.leads.T


class _Rows(mink.Task):
    """A residual and a Jacobian that jtik has evaluated; the error is zero until it is set."""

    def __init__(self, jacobian: Array) -> None:
        super().__init__(cost=np.ones(len(jacobian)))
        self.error, self.jacobian = np.zeros(len(jacobian)), jacobian

    def compute_error(self, configuration: mink.Configuration) -> Array:
        """The error as it was set."""
        return self.error

    def compute_jacobian(self, configuration: mink.Configuration) -> Array:
        """The Jacobian as it was set."""
        return self.jacobian


class _WeightedTask(BaseTask):
    """A task whose objective is multiplied by ``weight``."""

    def __init__(self, task: BaseTask, weight: float) -> None:
        self._task, self._weight = task, weight

    def compute_qp_objective(self, configuration: mink.Configuration) -> Objective:
        """The task's objective times the weight."""
        P, c = self._task.compute_qp_objective(configuration)
        return Objective(self._weight * P, self._weight * c)


class _Quadratic(BaseTask):
    """The objective 1/2 dq' metric dq + gradient' dq, with the gradient 0 until it is set."""

    def __init__(self, metric: Array) -> None:
        self.gradient, self._metric = np.zeros(len(metric)), metric

    def compute_qp_objective(self, configuration: mink.Configuration) -> Objective:
        """(metric, gradient)."""
        return Objective(self._metric, self.gradient)


def _error_damping(task: mink.Task, configuration: mink.Configuration) -> float:
    """The damping that mink adds for the error of a task."""
    error = task.cost * task.gain * task.compute_error(configuration)
    return float(task.lm_damping * (error @ error))


class _BoxLimit(mink.Limit):
    """low <= dq <= high on the robot's own velocities, where they are finite."""

    def __init__(self, places: MujocoCorrespondence) -> None:
        self._own = places.leads.T
        self.low, self.high = np.zeros((2, len(self._own)))

    def compute_qp_inequalities(self, configuration: mink.Configuration, dt: float) -> mink.Constraint:
        """G dq <= h; dt is not used."""
        up, down = np.isfinite(self.high), np.isfinite(self.low)
        if not (up.any() or down.any()):
            return mink.Constraint()
        return mink.Constraint(
            G=np.vstack([self._own[up], -self._own[down]]), h=np.concatenate([self.high[up], -self.low[down]])
        )
