"""A step's program as mink builds and solves it: the Python in the middle of the strategy "mink"."""

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
from jtik.interop.mink import Correspondence, to_mujoco
from jtik.task import Task, TaskStack
from jtik.types import Array

if TYPE_CHECKING:
    from jtik_formulations.strategies.mink_ik import Mink


_EXACT: dict[str, dict[str, Any]] = {
    "daqp": {"primal_tol": 1e-9},
    "osqp": {"eps_abs": 1e-9, "eps_rel": 1e-9, "max_iter": 20000, "polishing": True},
}
"""Where a solver's own tolerance is coarser than that of a solve."""

_HELD = 1e-6
"""What an equality may be missed by, relative to 1 + the error."""


class MinkStep:
    """One problem of mink's, filled with each step's numbers."""

    def __init__(
        self,
        law: Mink,
        robot: Robot,
        stack: TaskStack,
        *,
        strict_rows: Sequence[int],
        solver: str,
        has_criterion: bool,
    ) -> None:
        if solver not in qpsolvers.available_solvers:
            names = ", ".join(qpsolvers.available_solvers)
            more = "more come with: pip install 'qpsolvers[open-source-solvers]'"
            raise ArgumentError("solver", solver, f"one that mink can use: {names}; {more}")
        mujoco_model = to_mujoco(robot)
        mujoco_model.jnt_limited[:] = 0  # the box has them
        self._law, self._solver, self._robot = law, solver, robot
        self._places = Correspondence(robot, mujoco_model)
        self._configuration = mink.Configuration(mujoco_model)
        self._criterion = _Slope(mujoco_model.nv) if has_criterion else None
        self._below: list[BaseTask] = [*law.tasks, *([self._criterion] if self._criterion else [])]
        self._box = _BoxLimit(self._places)
        self._followers = [_Rows(self._places.follows)] if len(self._places.follows) else []
        self._parts: list[_Part] = []
        first, start = 0, 0
        for task in stack.tasks:
            last, stop = first + task.row_count(robot), start + task.target_size(robot)
            rows, numbers = slice(first, last), slice(start, stop)
            self._parts.append(_Part.of(task, robot, law, rows, numbers, self._places, strict=first in strict_rows))
            first, start = last, stop

    def __call__(self, numbers: Sequence[Array]) -> Sequence[Any] | None:
        """Displacement (n,), and 1 where it is the strict form's; None where mink finds neither."""
        q, target, residual, columns, slope, low, high = numbers
        self._configuration.update(self._places.qpos(q))
        J = columns.reshape(self._robot.n, -1).T
        for part in self._parts:
            part.read(target, residual, J)
        if self._criterion:
            self._criterion.slope = self._places.leads @ slope
        self._box.low, self._box.high = low, high
        strict = self._solved(strict=True) if self._law.strict else None
        if strict is not None:
            return strict, 1.0
        soft = self._solved(strict=False)
        return None if soft is None else (soft, 0.0)

    def _solved(self, *, strict: bool) -> Array | None:
        law = self._law
        equal = [part.task for part in self._parts if strict and part.strict]
        tasks: list[BaseTask] = [part.task for part in self._parts if not (strict and part.strict)]
        weight = law.weight if tasks else 1.0
        tasks += [_Weighed(task, weight) for task in self._below]
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # a solver on its interface: not the caller's business
                dq = mink.solve_ik(
                    configuration=self._configuration,
                    tasks=tasks,
                    dt=1.0,  # so that the velocity is the displacement
                    solver=self._solver,
                    damping=law.damping if tasks else 1.0,
                    limits=[self._box],
                    constraints=[*equal, *self._followers],
                    **_EXACT.get(self._solver, {}),
                )
        except (mink.NoSolutionFound, qpsolvers.exceptions.QPError, ValueError, ArithmeticError, RuntimeError):
            return None
        return self._places.velocity(dq) if self._holds(dq, equal) else None

    def _holds(self, dq: Array, equal: Sequence[mink.Task]) -> bool:
        """Whether the equalities do; a solver may call solved what has none."""
        for task in equal:
            error = task.gain * task.compute_error(self._configuration)
            left = task.compute_jacobian(self._configuration) @ dq + error
            if not np.abs(left).max() <= _HELD * (1 + np.abs(error).max()):
                return False
        return bool(np.isfinite(dq).all())


@dataclass(frozen=True)
class _Part:
    """A task of jtik's as one of mink's, and how it learns of a step's numbers."""

    task: mink.FrameTask | _Rows
    strict: bool
    rows: slice
    numbers: slice
    planar: bool
    places: Correspondence

    @classmethod
    def of(
        cls, task: Task, robot: Robot, law: Mink, rows: slice, numbers: slice, places: Correspondence, *, strict: bool
    ) -> _Part:
        """mink's FrameTask for a pose whose lengths weigh the same in all directions, and whose angles do."""
        planar = robot.dimension == 2
        weight = np.sqrt(np.diag(task.weight(rows.stop - rows.start)))
        made: mink.FrameTask | _Rows = _Rows(np.zeros((rows.stop - rows.start, len(places.leads))))
        if type(task) is FrameTask and task.kind == "pose" and task.axes is None and not planar:
            Kp = task.weight(6)
            if np.array_equal(Kp, np.diag([Kp[0, 0]] * 3 + [Kp[3, 3]] * 3)):
                costs = {"position_cost": weight[0], "orientation_cost": weight[3]}
                made = mink.FrameTask(frame_name=task.frame, frame_type="body", **costs)
        made.gain, made.lm_damping = law.gain, law.lm_damping
        return cls(made, strict, rows, numbers, planar, places)

    def read(self, target: Array, residual: Array, J: Array) -> None:
        """The numbers of a step."""
        if isinstance(self.task, mink.FrameTask):
            values, pose = target[self.numbers], np.eye(4)
            pose[:3, 3], pose[:3, :3] = values[:3], values[3:].reshape(3, 3).T
            self.task.set_target(mink.SE3.from_matrix(pose))
        else:
            self.task.error = residual[self.rows]
            self.task.jacobian = J[self.rows] @ self.places.leads.T


class _Rows(mink.Task):
    """A residual and its Jacobian that jtik has evaluated; without an error, rows that stay zero."""

    def __init__(self, jacobian: Array) -> None:
        super().__init__(cost=np.ones(len(jacobian)))
        self.error, self.jacobian = np.zeros(len(jacobian)), jacobian

    def compute_error(self, configuration: mink.Configuration) -> Array:
        """As it was handed over."""
        return self.error

    def compute_jacobian(self, configuration: mink.Configuration) -> Array:
        """As it was handed over."""
        return self.jacobian


class _Weighed(BaseTask):
    """A task whose objective counts ``weight`` times."""

    def __init__(self, task: BaseTask, weight: float) -> None:
        self._task, self._weight = task, weight

    def compute_qp_objective(self, configuration: mink.Configuration) -> Objective:
        """Of the task, times the weight."""
        P, c = self._task.compute_qp_objective(configuration)
        return Objective(self._weight * P, self._weight * c)


class _Slope(BaseTask):
    """1/2 |dq|^2 + slope' dq."""

    def __init__(self, nv: int) -> None:
        self.slope, self._identity = np.zeros(nv), np.eye(nv)

    def compute_qp_objective(self, configuration: mink.Configuration) -> Objective:
        """(I, slope)."""
        return Objective(self._identity, self.slope)


class _BoxLimit(mink.Limit):
    """low <= dq <= high on the robot's own velocities, where they are finite."""

    def __init__(self, places: Correspondence) -> None:
        self._own = places.leads.T
        self.low, self.high = np.zeros((2, len(self._own)))

    def compute_qp_inequalities(self, configuration: mink.Configuration, dt: float) -> mink.Constraint:
        """G dq <= h; dt has no part in it."""
        up, down = np.isfinite(self.high), np.isfinite(self.low)
        if not (up.any() or down.any()):
            return mink.Constraint()
        return mink.Constraint(
            G=np.vstack([self._own[up], -self._own[down]]), h=np.concatenate([self.high[up], -self.low[down]])
        )
