"""Problem setup: the reduced robot and its tasks, with the functions that generators need."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterable
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jtik.arguments import instance, integer, positive_integer
from jtik.problems.case import Case, ProblemSet, case_name
from jtik.problems.target_of import target_of
from jtik.robot import Robot
from jtik.solver import InverseKinematics
from jtik.symbolic import function, jacobian, symbol
from jtik.symbolic.compile import CompiledFunction
from jtik.task import Task
from jtik.task.reduction import reduced
from jtik.types import Array

STRATEGY = "hybrid"
"""Strategy that decides whether a target can be reached, where there is no closed form."""

MAX_ITERATIONS = 300
"""Maximum iterations of an attempt to reach a target."""


class ProblemSetup:
    """The reduced robot, as in `InverseKinematics.robot`, and its tasks.

    Args:
        robot: the robot.
        task: a Task, or several.
        joints: joints that move, as in `InverseKinematics`.
        at: configuration at which the other joints are locked, as in `InverseKinematics`.

    Raises:
        ArgumentError: for an argument that `InverseKinematics` refuses.
        UnknownNameError: for an unknown frame or joint.
    """

    def __init__(
        self,
        robot: Robot,
        task: Task | Iterable[Task],
        joints: str | Iterable[str] | None = None,
        at: ArrayLike | None = None,
    ) -> None:
        instance("robot", robot, Robot, "a jtik.Robot")
        self.robot, self.tasks = reduced(robot, task, joints, at)

    def target_at(self, q: Array) -> Any:
        """The target that q meets exactly; a dict by task name for several tasks."""
        targets = {task.name: target_of(task, self.robot, q) for task in self.tasks.tasks}
        return targets if len(targets) > 1 else next(iter(targets.values()))

    def clamped(self, q: Array) -> Array:
        """q clamped to the joint limits."""
        return np.clip(q, self.robot.lower, self.robot.upper)

    def solve(
        self,
        target: Any,
        q0: Array,
        *,
        restarts: int = 0,
        max_iterations: int = MAX_ITERATIONS,
        tolerance: float = 1e-7,
    ) -> Array | None:
        """A configuration within the limits that meets the target to ``tolerance`` [m] and [rad]; None if not found."""
        solution = self._solver.solve(
            target,
            q0=q0,
            restarts=restarts,
            max_iterations=max_iterations,
            until="reached",
            position_tolerance=tolerance,
            orientation_tolerance=tolerance,
        )
        return solution.q if solution.converged else None

    def jacobian(self, q: Array) -> Array:
        """Jacobian of the task error (m, n) at q, for the target that q meets."""
        return self._jacobian(q, self.tasks.read_target(self.target_at(q)))[0]

    def jacobian_rate(self, q: Array, u: Array) -> Array:
        """Derivative of J(q)' u with respect to the velocity, (n, n), for the target that q meets."""
        return self._jacobian_rate(q, self.tasks.read_target(self.target_at(q)), u)[0]

    @cached_property
    def _solver(self) -> InverseKinematics:
        return InverseKinematics(self.robot, self.tasks.tasks, strategy=STRATEGY, joints="all")

    @cached_property
    def _jacobian(self) -> CompiledFunction:
        q, target = symbol("q", self.robot.nq), symbol("target", self.tasks.target_size)
        rows = self.tasks.rows(self.robot.at(q), target)
        return CompiledFunction(function("jacobian", [q, target], [rows.jacobian]))

    @cached_property
    def _jacobian_rate(self) -> CompiledFunction:
        q, target = symbol("q", self.robot.nq), symbol("target", self.tasks.target_size)
        rows = self.tasks.rows(self.robot.at(q), target)
        u = symbol("u", len(rows.linear))
        rate = jacobian(rows.jacobian.T @ u, q) @ self.robot.tangent(q)
        return CompiledFunction(function("jacobian_rate", [q, target, u], [rate]))


def draw_set(
    kind: str, count: int, seed: int, draw: Callable[[str, np.random.Generator], Case], origin: str
) -> ProblemSet:
    """Draw a set of ``count`` cases, each with its own random generator, so that case i does not depend on count.

    Args:
        kind: kind of the cases, and name of the set.
        count: number of cases.
        seed: seed of the random numbers; the generator of case i is ``default_rng([seed, crc32(kind), i])``.
        draw: (name, generator) -> case.
        origin: how the cases are drawn.

    Raises:
        ArgumentError: unless count is a positive integer and seed a non-negative one.
    """
    count, seed = positive_integer("count", count), integer("seed", seed)
    stream = zlib.crc32(kind.encode())
    cases = [draw(case_name(kind, i), np.random.default_rng([seed, stream, i])) for i in range(count)]
    return ProblemSet(kind, tuple(cases), seed, origin)
