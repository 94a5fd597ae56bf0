"""Shared part of mink and pink: one quadratic program for each step, with weighted tasks and equality constraints.

Without a criterion, the frame task is weighted and damped, with values with which such loops converge. With a
criterion, this is used far from the target. Close to the target the frame task becomes an equality constraint and the
criterion the objective, so that the answer reaches the target instead of a compromise between target and H. If the
constraint has no solution, for instance at a rank loss, the step is a weighted one.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from jtik.study.peers.base import Goal, Peer
from jtik.study.peers.loop import METRE, StepLoop
from jtik.types import Array

CLOSE = 0.2
"""Error below which the criterion is minimised [rad], where a metre counts as METRE radians."""

CLOSE = 1e-3
"""Error in the same unit up to which a rise of the error is accepted."""

FIRST_MAX_STEP = 0.3
"""Initial maximum length of a step on the criterion [rad, m]; damping proportional to its gradient enforces it."""

SHORTER, LONGER = 0.25, 1.1
"""Factors on that length after a step that raised H or the error, and after any other step.

Longer steps converge faster on a criterion like joint centring, and do not converge on one like obstacle avoidance.
"""


@dataclass(kw_only=True)
class DifferentialPeer(Peer):
    """Options of a loop over a differential solver.

    Attributes:
        solver: name of the QP solver in qpsolvers.
        orientation_cost: cost of one radian relative to one metre.
        lm_damping: Levenberg-Marquardt damping of the task, proportional to its error.
        limit_gain: share of the distance to a joint limit that a step may use.
        restarted: maximum steps of an attempt if restarts are allowed.
    """

    solver: str = "daqp"
    orientation_cost: float = 0.25
    lm_damping: float = 0.1
    limit_gain: float = 0.999
    restarted: int = 15


class FrameRows:
    """The rows of a frame task that belong to the goal, as a constraint: error and Jacobian without costs."""

    gain = 1.0

    def __init__(self, task: Any, goal: Goal) -> None:
        position, orientation = ([0, 1], [5]) if goal.planar else ([0, 1, 2], [3, 4, 5])
        self._task = task
        self._rows = [*(position if goal.has_position else []), *(orientation if goal.has_orientation else [])]

    def compute_error(self, configuration: Any) -> Array:
        """Error (k,): rows of the body twist to the target."""
        error: Array = self._task.compute_error(configuration)[self._rows]
        return error

    def compute_jacobian(self, configuration: Any) -> Array:
        """Jacobian (k, nv)."""
        J: Array = self._task.compute_jacobian(configuration)[self._rows]
        return J


class DampedCriterion:
    """A criterion as a task, whose convex Hessian is damped so that no step is longer than ``max_step``.

    Attributes:
        P: Hessian of the latest quadratic program.
        c: gradient of the latest quadratic program.
        gradient_norm: norm of the part of c along which the latest step could move; inf without such a step.
        max_step: maximum length of a step [rad, m]; smaller after a step that raised H or the error, else larger.
    """

    def __init__(self, task: Any) -> None:
        self._task = task
        self.parameters = task.parameters
        self.P, self.c, self.gradient_norm = np.zeros((0, 0)), np.zeros(0), math.inf
        self.max_step, self._error, self._H = FIRST_MAX_STEP, math.inf, math.inf

    def compute_qp_residual(self, configuration: Any) -> None:
        """None, so that mink calls `compute_qp_objective`."""

    def compute_qp_objective(self, configuration: Any) -> tuple[Array, Array]:
        """Hessian and gradient (P, c) in the library's velocities."""
        P, c = self._task.compute_qp_objective(configuration)
        self.P, self.c = P + (np.linalg.norm(c) / self.max_step + 1e-9) * np.eye(len(c)), c
        return self.P, self.c

    def restart(self) -> None:
        """Reset the memory of the latest steps."""
        self.gradient_norm, self.max_step, self._error, self._H = math.inf, FIRST_MAX_STEP, math.inf, math.inf

    def observe(self, configuration: Any, error: float) -> None:
        """Update ``max_step`` from the effect of the latest step."""
        H = self._task.value(configuration)
        allowed = float(np.linalg.norm(self.c)) * self._error  # a correction of the error may raise H
        worse = error > max(self._error, CLOSE) or (error <= CLOSE and self._H + allowed < H)
        self.max_step *= SHORTER if worse else LONGER
        self._error, self._H = error, H


class DifferentialLoop(StepLoop):
    """A loop over steps of a library whose ``solve_ik`` accepts tasks and constraints.

    A subclass sets ``configuration``, ``task`` and ``criterion``, and converts configurations.
    """

    configuration: Any
    task: Any
    criterion: DampedCriterion | None = None

    def __init__(self, library: Any, goal: Goal, options: DifferentialPeer, no_answer: type[Exception]) -> None:
        super().__init__(goal, restarted=options.restarted)
        self._library, self._options, self._no_answer = library, options, no_answer
        self._limits: list[Any] = []
        self._error, self._low = math.inf, -math.inf  # the criterion is minimised if low < error <= CLOSE
        self._first: dict[str, Array] = {}

    def set_target(self, target: Any) -> None:
        """Set the task's target."""
        self.task.set_target(target)

    def displacement(self, tasks: list[Any], constraints: list[Any], **more: Any) -> Array | None:
        """The displacement of ``solve_ik`` with dt = 1; None if it finds no solution."""
        try:
            dq: Array = self._library.solve_ik(
                configuration=self.configuration,
                tasks=tasks,
                dt=1.0,
                solver=self._options.solver,
                limits=self._limits,
                constraints=constraints or None,
                **more,
            )
        except self._no_answer:
            return None
        return dq if np.isfinite(dq).all() else None

    @abstractmethod
    def library_configuration(self, q: Array) -> Array:
        """The library's configuration for the robot's (nq,)."""

    def set_configuration(self, q: Array) -> None:
        """Set the library's configuration and reset the memory of the criterion."""
        if self.criterion is not None:
            self.criterion.restart()
        self.configuration.update(self.library_configuration(q))

    def minimise(self, task: Any) -> None:
        """Add a criterion, given as a task of the library."""
        self.criterion = DampedCriterion(task)
        self._first = {name: np.array(value) for name, value in task.parameters.items()}
        if self.goal.setting.until == "stationary":
            self.success_status = "CONVERGED"
        else:
            self._low = CLOSE  # reaching the target is enough; a step on H would leave it again

    def set(self, parameters: Mapping[str, Array]) -> None:
        """Set live parameters of the criterion; those that are not given return to their first values."""
        if self.criterion is not None:
            for name, value in self._first.items():
                self.criterion.parameters[name] = parameters.get(name, value)

    def error(self) -> tuple[float, float]:
        """Errors by the task itself: a body twist, whose linear part is never shorter than the distance."""
        x, y, z, a, b, c = self.task.compute_error(self.configuration).tolist()
        position = math.sqrt(x * x + y * y + z * z) if self.goal.has_position else 0.0
        orientation = math.sqrt(a * a + b * b + c * c) if self.goal.has_orientation else 0.0
        self._error = METRE * position + orientation
        return position, orientation

    def may_continue(self, position: float, orientation: float) -> bool:
        """Also close to the target, where a step on H increases the error slightly."""
        return super().may_continue(position, orientation) or (
            self.success_status == "CONVERGED" and self._error <= CLOSE
        )

    def step(self) -> float | None:
        """A step with the target as a constraint if there is a criterion and the error is small, else weighted."""
        dq = None
        if self.criterion is not None and self._low < self._error <= CLOSE:
            self.criterion.observe(self.configuration, self._error)
            dq = self.displacement([self.criterion], [FrameRows(self.task, self.goal)])
            if dq is not None:
                self.criterion.gradient_norm = float(np.linalg.norm(self.criterion.P @ dq))
        if dq is None:
            dq = self.displacement([self.task], [])
            if self.criterion is not None:
                self.criterion.gradient_norm = math.inf
        if dq is None:
            return None
        self.configuration.integrate_inplace(dq, 1.0)
        return math.sqrt(dq @ dq)

    def is_stationary(self) -> bool:
        """With ``until="stationary"``: whether the gradient along the latest constrained step is within tolerance."""
        setting, criterion = self.goal.setting, self.criterion
        if criterion is None or setting.until == "reached":
            return True
        return criterion.gradient_norm <= setting.optimality_tolerance * max(1.0, float(np.linalg.norm(criterion.c)))
