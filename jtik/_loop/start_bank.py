"""Starts of a search in lanes: the restart configurations in the order of their distance from each target.

A restart that begins close to the target more often reaches it, and in fewer iterations. What the tasks read of a pose
is known for each configuration of the bank, as the numbers of a target; the distance of two such lists of numbers is a
weighted sum of squares, whose weights make it V, approximately (formulations/restarts.md).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from jtik._loop.restarts import BLOCK, RestartConfigurations
from jtik._step.symbolic_problem import SymbolicProblem
from jtik.symbolic import Function, function
from jtik.symbolic.compile import CompiledFunction
from jtik.types import Array

SIZE = 256
"""Number of configurations in a bank."""

ALIGNMENT = 64
"""Alignment of vectors in memory [bytes]."""


def aligned(size: int) -> Array:
    """Zeros (size,) at an address where vectors may lie."""
    memory = np.zeros(size + ALIGNMENT // 8)
    begin = -memory.ctypes.data % ALIGNMENT // 8
    return memory[begin : begin + size]


class StartBank(NamedTuple):
    """Configurations, and what their distance from a target is.

    Attributes:
        configurations: the configurations, (SIZE, nq).
        coefficients: of a distance as an affine function of a target's numbers: the constants, then the factors of each
            number, (1 + target size, SIZE), aligned.
    """

    configurations: Array
    coefficients: Array

    @property
    def starts(self) -> tuple[Array, int, int]:
        """The configurations, and the numbers of the first and of the last restart."""
        return self.configurations, 1, len(self.configurations)

    def distances(self, target: Array) -> Array:
        """The distance of each configuration from a target (target size,), less that of the target from zero."""
        distances: Array = self.coefficients[0] + target @ self.coefficients[1:]
        return distances


class StartBanks:
    """The banks of a problem, each drawn for a seed.

    Args:
        problem: the problem; its restarts must not depend on where a search begins.
    """

    def __init__(self, problem: SymbolicProblem) -> None:
        self._problem = problem
        self._latest: tuple[int, StartBank] | None = None

    def of(self, seed: int) -> StartBank:
        """The bank for a seed; the latest one is kept."""
        latest = self._latest  # copies of a solver in several threads share it
        if latest is None or latest[0] != seed:
            robot = self._problem.robot
            drawn, nothing = RestartConfigurations(robot), np.zeros(robot.nq)
            blocks = [drawn.block(seed, 1 + number, nothing)[0] for number in range(0, SIZE, BLOCK)]
            latest = self._latest = seed, _bank(self._problem, np.concatenate(blocks))
        return latest[1]


def _held(problem: SymbolicProblem) -> Function:
    """The numbers of the target that a configuration meets, (q, target) -> numbers."""
    q, target, _ = problem.symbols()
    return function("held", [q, target], [problem.tasks.held_target(problem.robot.at(q), target)])


def _bank(problem: SymbolicProblem, configurations: Array) -> StartBank:
    """The bank of configurations (SIZE, nq)."""
    numbers_at = CompiledFunction(problem.once("held target", lambda: _held(problem)))
    residual = CompiledFunction(problem.residual)
    zero = np.zeros(problem.tasks.target_size)
    numbers = np.array([numbers_at(each, zero)[0][:, 0] for each in configurations])
    others = np.roll(numbers, 1, axis=0)
    V = [np.sum(residual(each, other)[0] ** 2) / 2 for each, other in zip(configurations, others, strict=True)]
    weights = _weights((numbers - others) ** 2, np.array(V))
    coefficients = aligned((1 + len(zero)) * SIZE).reshape(1 + len(zero), SIZE)
    coefficients[0] = numbers**2 @ weights
    coefficients[1:] = -2 * (numbers * weights).T
    return StartBank(configurations, coefficients)


def _weights(squares: Array, V: Array) -> Array:
    """Non-negative weights (k,) with which the sum of ``squares`` (count, k) is ``V`` (count,), by least squares."""
    known = np.isfinite(squares).all(axis=1) & np.isfinite(V)
    if not known.any():
        return np.zeros(squares.shape[1])
    weights: Array = np.maximum(np.linalg.lstsq(squares[known], V[known], rcond=None)[0], 0.0)
    return weights
