"""What problems are drawn for: the robot that a solver would move, its tasks, and numbers about both."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterable
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jtik.errors import ArgumentError
from jtik.problems.case import Case, ProblemSet, case_name
from jtik.problems.reached import target_of
from jtik.robot import Robot
from jtik.solver import InverseKinematics
from jtik.symbolic import function, jacobian, symbol
from jtik.symbolic.compile import CompiledFunction
from jtik.task import Task
from jtik.task.reduction import reduced
from jtik.types import Array

STRATEGY = "hybrid"
"""What decides whether a target can be reached, where no closed form does."""

STEPS = 300
"""Most iterations of such an attempt."""


class Subject:
    """The reduced robot, as `InverseKinematics.robot` is, and the tasks on it.

    Args:
        robot, task, joints, at: as `InverseKinematics` takes them.

    Raises:
        ArgumentError, UnknownNameError: for what `InverseKinematics` would not take.
    """

    def __init__(
        self,
        robot: Robot,
        task: Task | Iterable[Task],
        joints: str | Iterable[str] | None = None,
        at: ArrayLike | None = None,
    ) -> None:
        if not isinstance(robot, Robot):
            raise ArgumentError("robot", robot, "a jtik.Robot")
        self.robot, self.tasks = reduced(robot, task, joints, at)

    def target_at(self, q: Array) -> Any:
        """The target that the robot meets at q: of one task, or a dict of several."""
        targets = {task.name: target_of(task, self.robot, q) for task in self.tasks.tasks}
        return targets if len(targets) > 1 else next(iter(targets.values()))

    def led_in(self, q: Array) -> Array:
        """q with every joint within its limits."""
        return np.clip(q, self.robot.lower, self.robot.upper)

    def arrival(
        self, target: Any, q0: Array, *, restarts: int = 0, steps: int = STEPS, tolerance: float = 1e-7
    ) -> Array | None:
        """A configuration that meets the target within ``tolerance`` [m] and [rad] and the limits, or None."""
        solution = self._solver.solve(
            target,
            q0=q0,
            restarts=restarts,
            max_iterations=steps,
            until="reached",
            position_tolerance=tolerance,
            orientation_tolerance=tolerance,
        )
        return solution.q if solution.converged else None

    def jacobian(self, q: Array) -> Array:
        """Jacobian of the task error (m, n) at q, where q meets the target."""
        return self._jacobian(q, self.tasks.read_target(self.target_at(q)))[0]

    def dual_rate(self, q: Array, u: Array) -> Array:
        """Derivative of J(q)' u with respect to the velocity, (n, n), where q meets the target."""
        return self._dual_rate(q, self.tasks.read_target(self.target_at(q)), u)[0]

    @cached_property
    def _solver(self) -> InverseKinematics:
        return InverseKinematics(self.robot, self.tasks.tasks, strategy=STRATEGY, joints="all")

    @cached_property
    def _jacobian(self) -> CompiledFunction:
        q, target = symbol("q", self.robot.nq), symbol("target", self.tasks.target_size)
        rows = self.tasks.rows(self.robot.at(q), target)
        return CompiledFunction(function("jacobian", [q, target], [rows.jacobian]))

    @cached_property
    def _dual_rate(self) -> CompiledFunction:
        q, target = symbol("q", self.robot.nq), symbol("target", self.tasks.target_size)
        rows = self.tasks.rows(self.robot.at(q), target)
        u = symbol("u", len(rows.linear))
        rate = jacobian(rows.jacobian.T @ u, q) @ self.robot.tangent(q)
        return CompiledFunction(function("dual_rate", [q, target, u], [rate]))


def drawn(
    kind: str, count: int, seed: int, draw: Callable[[str, np.random.Generator], Case], origin: str
) -> ProblemSet:
    """A set of ``count`` cases, each from a generator of its own: the first ones do not depend on how many follow.

    Args:
        kind: of the cases, which is also the name of the set.
        count: how many.
        seed: of the random numbers; the generator of case i is ``default_rng([seed, crc32(kind), i])``.
        draw: (name, generator) -> case.
        origin: how they are drawn.

    Raises:
        ArgumentError: when count or seed is not a whole number.
    """
    for argument, value, least in (("count", count, 1), ("seed", seed, 0)):
        if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < least:
            raise ArgumentError(argument, value, f"an integer from {least}")
    stream = zlib.crc32(kind.encode())
    cases = [draw(case_name(kind, i), np.random.default_rng([int(seed), stream, i])) for i in range(count)]
    return ProblemSet(kind, tuple(cases), int(seed), origin)
