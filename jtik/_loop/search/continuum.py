"""Whether two configurations on target are of one continuum: the motion of a singular pose that stays on target."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import numpy as np

from jtik._loop.search.full_turns import TURN, FullTurns
from jtik._step.symbolic_problem import SymbolicProblem
from jtik.symbolic import Function, function
from jtik.symbolic.compile import CompiledFunction
from jtik.types import Array

WEAK = 1e-3
"""A singular value of J below this fraction of the largest is that of a weak direction."""

STEP = 0.15
"""Longest step along weak directions [rad]."""

STEPS = 60
"""Largest number of steps: more than a turn of two joints."""

PROGRESS = 1e-2
"""Smallest part of the way that is left in the weak directions, below which they lead no nearer."""

CORRECTIONS = 2
"""Corrections of a step, along the other directions."""


class Continuum:
    """Walks from one configuration on target towards another along the weak directions of J.

    Only for a robot without redundancy: the self-motion of a redundant one connects postures that differ.

    Args:
        problem: the problem.
        turns: the joints that can turn all the way round.
    """

    def __init__(self, problem: SymbolicProblem, turns: FullTurns) -> None:
        self._problem, self._robot = problem, problem.robot
        self._possible = problem.robot.n <= problem.m
        v_of_q = dict(zip(problem.robot.scalar_q.tolist(), problem.robot.scalar_v.tolist(), strict=True))
        self._turning = [v_of_q[i] for i in turns.indices.tolist()]

    @cached_property
    def _evaluate(self) -> CompiledFunction:
        def build() -> Function:
            q, target, _ = self._problem.symbols()
            parts = [self._problem.residual(q, target), self._problem.residual_jacobian(q, target)]
            return function("residual_and_jacobian", [q, target], parts)

        return CompiledFunction(self._problem.once("residual_and_jacobian", build))

    def way(self, q: Array, other: Array) -> Array:
        """The displacement from q to another configuration, (n,), without whole turns of joints that can turn."""
        v = np.array(self._robot.difference(q, other))
        v[self._turning] -= TURN * np.rint(v[self._turning] / TURN)
        return v

    def leads(self, q: Array, other: Array, target: Array, near: float, on_target: Callable[[Array], bool]) -> bool:
        """Whether a motion along weak directions that stays on target leads from q to the other configuration.

        Args:
            q: configuration on target, (nq,).
            other: another one.
            target: the numbers of the target.
            near: largest distance of a joint at which it has arrived [rad] or [m].
            on_target: whether a configuration is on target, within the tolerances.
        """
        before = np.inf
        for _ in range(STEPS if self._possible else 0):
            left = self.way(q, other)
            if np.abs(left).max() <= near:
                return True
            distance = float(np.linalg.norm(left))
            if distance >= before:
                return False
            before, J = distance, self._evaluate(q, target)[1]
            _, sizes, directions = np.linalg.svd(J)
            weak = directions[np.count_nonzero(sizes >= WEAK * sizes[0]) :]
            step = weak.T @ (weak @ left)
            length = float(np.linalg.norm(step))
            if length < PROGRESS * distance:
                return False
            q = np.asarray(self._robot.integrate(q, min(1.0, STEP / length) * step))
            for _ in range(CORRECTIONS):
                residual, J = self._evaluate(q, target)
                q = np.asarray(self._robot.integrate(q, -np.linalg.pinv(J, rcond=WEAK) @ residual[:, 0]))
            if not on_target(q):
                return False
        return False
