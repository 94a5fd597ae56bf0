"""What mink and pink have in common: a quadratic program a step, of tasks that are weighted or, as constraints, strict.

Without a criterion the frame's task is the weighted one, with the damping that makes such loops converge. With one,
that is the way in; near the target the frame's task becomes a constraint and the criterion the objective, so that the
answer is on target and does not trade the target for H. Where the constraint has no solution, as at a rank loss, the
step is a weighted one again.
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

NEAR = 0.2
"""Error [rad; a metre counts as METRE of them] below which the criterion takes its part."""

CLOSE = 1e-3
"""Error, likewise, up to which it may come and go."""

FIRST_MAX_STEP = 0.3
"""Longest step [rad, m] down the criterion at first, by damping in proportion to its gradient_norm."""

SHORTER, LONGER = 0.25, 1.1
"""What becomes of that length after a step that made things worse, and after any other. Longer steps arrive sooner on a
criterion like joint centring and never on one like obstacle avoidance."""


@dataclass(kw_only=True)
class DifferentialPeer(Peer):
    """Options of a loop round a differential solver.

    Attributes:
        solver: what qpsolvers solves the programs with.
        orientation_cost: cost of a radian where a metre costs 1.
        lm_damping: Levenberg-Marquardt damping of the task, in proportion to its error.
        limit_gain: which part of the way to a joint limit a step may go.
        restarted: most steps of an attempt where restarts are allowed.
    """

    solver: str = "daqp"
    orientation_cost: float = 0.25
    lm_damping: float = 0.1
    limit_gain: float = 0.999
    restarted: int = 15


class FrameRows:
    """The rows of a frame task that matter, as a constraint: error and Jacobian without costs."""

    gain = 1.0

    def __init__(self, task: Any, goal: Goal) -> None:
        position, orientation = ([0, 1], [5]) if goal.planar else ([0, 1, 2], [3, 4, 5])
        self._task = task
        self._rows = [*(position if goal.has_position else []), *(orientation if goal.has_orientation else [])]

    def compute_error(self, configuration: Any) -> Array:
        """(k,) of the body twist to the target."""
        error: Array = self._task.compute_error(configuration)[self._rows]
        return error

    def compute_jacobian(self, configuration: Any) -> Array:
        """(k, nv)."""
        J: Array = self._task.compute_jacobian(configuration)[self._rows]
        return J


class DampedCriterion:
    """A criterion as a task, its convex part damped so that no step is longer than ``max_step``.

    Attributes:
        P, c: of the latest program.
        gradient_norm: norm of the part of c along which the latest step could go; inf where none was made.
        max_step: shorter after a step that made H or the error larger, else longer [rad, m].
    """

    def __init__(self, task: Any) -> None:
        self._task = task
        self.parameters = task.parameters
        self.P, self.c, self.gradient_norm = np.zeros((0, 0)), np.zeros(0), math.inf
        self.max_step, self._error, self._H = FIRST_MAX_STEP, math.inf, math.inf

    def compute_qp_residual(self, configuration: Any) -> None:
        """None: mink is to ask for the objective."""

    def compute_qp_objective(self, configuration: Any) -> tuple[Array, Array]:
        """(P, c) in the library's velocities."""
        P, c = self._task.compute_qp_objective(configuration)
        self.P, self.c = P + (np.linalg.norm(c) / self.max_step + 1e-9) * np.eye(len(c)), c
        return self.P, self.c

    def restart(self) -> None:
        """Forget the latest steps."""
        self.gradient_norm, self.max_step, self._error, self._H = math.inf, FIRST_MAX_STEP, math.inf, math.inf

    def observe(self, configuration: Any, error: float) -> None:
        """See what the latest step has done, before the next one."""
        H = self._task.value(configuration)
        allowed = float(np.linalg.norm(self.c)) * self._error  # the way back to the target may lead up H
        worse = error > max(self._error, CLOSE) or (error <= CLOSE and self._H + allowed < H)
        self.max_step *= SHORTER if worse else LONGER
        self._error, self._H = error, H


class DifferentialLoop(StepLoop):
    """Steps of a library whose ``solve_ik`` takes tasks and constraints.

    A subclass sets ``configuration``, ``task`` and ``criterion`` and says how to solve and where it is.
    """

    configuration: Any
    task: Any
    criterion: DampedCriterion | None = None

    def __init__(self, library: Any, goal: Goal, options: DifferentialPeer, no_answer: type[Exception]) -> None:
        super().__init__(goal, restarted=options.restarted)
        self._library, self._options, self._no_answer = library, options, no_answer
        self._limits: list[Any] = []
        self._near, self._low = math.inf, -math.inf  # the criterion has a part where low < near <= NEAR
        self._first: dict[str, Array] = {}

    def set_target(self, target: Any) -> None:
        """Set the task's target."""
        self.task.set_target(target)

    def displacement(self, tasks: list[Any], constraints: list[Any], **more: Any) -> Array | None:
        """What ``solve_ik`` answers with dt = 1, or None when it finds no solution."""
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
        """Set the library's configuration; of the criterion's gradient_norm there nothing is known."""
        if self.criterion is not None:
            self.criterion.restart()
        self.configuration.update(self.library_configuration(q))

    def minimise(self, task: Any) -> None:
        """Take a criterion, as a task of the library."""
        self.criterion = DampedCriterion(task)
        self._first = {name: np.array(value) for name, value in task.parameters.items()}
        if self.goal.setting.until == "stationary":
            self.arrival = "CONVERGED"
        else:
            self._low = CLOSE  # to arrive is enough, and a step down H would lead away again

    def set(self, parameters: Mapping[str, Array]) -> None:
        """Live parameters of the criterion; those that are not named get their first values back."""
        if self.criterion is not None:
            for name, value in self._first.items():
                self.criterion.parameters[name] = parameters.get(name, value)

    def error(self) -> tuple[float, float]:
        """Of the task itself: a body twist, whose linear part is never shorter than the distance."""
        x, y, z, a, b, c = self.task.compute_error(self.configuration).tolist()
        position = math.sqrt(x * x + y * y + z * z) if self.goal.has_position else 0.0
        orientation = math.sqrt(a * a + b * b + c * c) if self.goal.has_orientation else 0.0
        self._near = METRE * position + orientation
        return position, orientation

    def may_continue(self, position: float, orientation: float) -> bool:
        """Also near the target, which a step down H leaves a little."""
        return super().may_continue(position, orientation) or (self.arrival == "CONVERGED" and self._near <= NEAR)

    def step(self) -> float | None:
        """Strict where there is a criterion and the target is near, else weighted."""
        dq = None
        if self.criterion is not None and self._low < self._near <= NEAR:
            self.criterion.observe(self.configuration, self._near)
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
        """With a criterion to be stationary: whether the latest strict step found no gradient_norm to go down."""
        setting, criterion = self.goal.setting, self.criterion
        if criterion is None or setting.until == "reached":
            return True
        return criterion.gradient_norm <= setting.optimality_tolerance * max(1.0, float(np.linalg.norm(criterion.c)))
