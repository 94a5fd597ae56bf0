"""Restart configurations in the order of their distance from a target.

A restart that begins close to the target more often reaches it, and in fewer iterations. What the tasks read of a pose
is known for each configuration of a bank, as the numbers of a target; the distance of two such lists of numbers is a
weighted sum of squares, whose weights make it V, approximately (formulations/restarts.md).
"""

from __future__ import annotations

import math
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from jtik._loop.search.restarts import BLOCK, RestartConfigurations
from jtik._step.symbolic_problem import SymbolicProblem
from jtik.symbolic import Function, function
from jtik.symbolic.compile import CompiledFunction
from jtik.types import Array

SIZE = 256
"""Number of configurations in a bank, a power of two: the lowest bits of a key are the row."""

FITTED = 0
"""Seed of the configurations between which the distance is fitted to V."""

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
        coefficients: of a distance as an affine function of a target's numbers less the centre: the constants, then the
            factors of each number, (1 + target size, SIZE), aligned.
        centre: the mean of the numbers, (target size,): differences from it have the smallest rounding errors.
        numbers: the numbers of the targets that the configurations meet, (SIZE, target size).
    """

    configurations: Array
    coefficients: NDArray[np.float32]
    centre: Array
    numbers: Array

    @property
    def starts(self) -> tuple[Array, int, int]:
        """The configurations, and the numbers of the first and of the last restart."""
        return self.configurations, 1, len(self.configurations)

    def distances(self, target: Array) -> NDArray[np.float32]:
        """The distance of each configuration from a target (target size,), less that of the target from the centre.

        The sums are those of the searches in C, in the same order.
        """
        distances: NDArray[np.float32] = self.coefficients[0].copy()
        with np.errstate(all="ignore"):
            apart = (target - self.centre).astype(np.float32)
            for number, factors in zip(apart, self.coefficients[1:], strict=True):
                distances += number * factors
        return distances

    def keys(self, target: Array) -> NDArray[np.int32]:
        """Integers (SIZE,) in the order of the distances: in their upper bits a distance, in the lower ones the row.

        A distance has the upper 24 of its 32 bits there; configurations without a finite one have the largest keys.
        """
        distances = self.distances(target)
        distances[~np.isfinite(distances)] = math.inf
        keys = distances.view(np.int32)
        keys ^= (keys >> 31) & np.iinfo(np.int32).max  # integers in the order of the numbers
        return (keys & -SIZE) | np.arange(SIZE, dtype=np.int32)

    def order(self, target: Array) -> NDArray[np.intp]:
        """The rows of the configurations in the order of their keys, the closest to the target first."""
        return np.argsort(self.keys(target))


class StartBanks:
    """The banks of a problem, each drawn for a seed.

    Args:
        problem: the problem; its restarts must not depend on where a search begins.
    """

    def __init__(self, problem: SymbolicProblem) -> None:
        self._problem = problem
        self._latest: tuple[int, StartBank] | None = None

    def warm_up(self) -> None:
        """Build what the first bank needs, and draw that of seed 0."""
        self.of(0)

    def known(self, seed: int) -> StartBank | None:
        """The bank for a seed, where it is the latest one."""
        latest = self._latest
        return latest[1] if latest is not None and latest[0] == seed else None

    def of(self, seed: int) -> StartBank:
        """The bank for a seed; the latest one is kept."""
        bank = self.known(seed)
        if bank is None:
            bank = self._bank(self._drawn(seed))
            self._latest = seed, bank
        return bank

    def _drawn(self, seed: int) -> Array:
        """The first restarts with a seed, (SIZE, nq)."""
        restarts, nothing = RestartConfigurations(self._problem.robot), np.zeros(self._problem.robot.nq)
        return np.concatenate([restarts.block(seed, 1 + number, nothing)[0] for number in range(0, SIZE, BLOCK)])

    def _bank(self, configurations: Array) -> StartBank:
        """The bank of configurations (SIZE, nq)."""
        numbers, weights = self._numbers(configurations), self._weights
        coefficients = aligned((1 + len(weights)) * SIZE // 2).view(np.float32).reshape(1 + len(weights), SIZE)
        known = np.isfinite(numbers).all(axis=1)
        with np.errstate(all="ignore"):
            centre = numbers[known].mean(axis=0) if known.any() else np.zeros(len(weights))
            apart = numbers - centre
            coefficients[0] = apart**2 @ weights
            coefficients[1:] = -2 * (apart * weights).T
        return StartBank(configurations, coefficients, centre, numbers)

    @cached_property
    def _held(self) -> Function:
        """Configurations (nq, SIZE) -> the numbers of the targets that they meet, 0 where a task does not say."""
        problem = self._problem
        q, target, _ = problem.symbols()
        held = problem.tasks.held_target(problem.robot.at(q), target * 0)
        return function("held", [q], [held]).map(SIZE)

    def _numbers(self, configurations: Array) -> Array:
        """The numbers of the targets that configurations (SIZE, nq) meet, (SIZE, target size)."""
        return CompiledFunction(self._held)(configurations.T)[0].T

    @cached_property
    def _weights(self) -> Array:
        """The weights of the numbers with which the distance is V, approximately, (target size,)."""
        configurations = self._drawn(FITTED)
        numbers = self._numbers(configurations)
        others = np.roll(numbers, 1, axis=0)
        residuals = CompiledFunction(self._problem.residual.map(SIZE))(configurations.T, others.T)[0]
        return _fitted((numbers - others) ** 2, np.sum(residuals**2, axis=0) / 2)


def _fitted(squares: Array, V: Array) -> Array:
    """Non-negative weights (k,) with which the sum of ``squares`` (count, k) is ``V`` (count,), by least squares."""
    known = np.isfinite(squares).all(axis=1) & np.isfinite(V)
    if not known.any():
        return np.zeros(squares.shape[1])
    weights: Array = np.maximum(np.linalg.lstsq(squares[known], V[known], rcond=None)[0], 0.0)
    return weights
