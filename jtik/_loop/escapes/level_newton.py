"""Newton's method for levels of priority whose highest is out of reach (formulations/lexicographic_qp.md).

Such a level is closest to its target where its Jacobian loses rank, and the levels below have a freedom beside it to
first order only. Steps without its curvature converge slowly along the boundary of its reach; with the Hessian of each
level they converge quadratically.
"""

from __future__ import annotations

from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from jtik._step.inputs import Inputs
from jtik._step.symbolic_problem import SymbolicProblem
from jtik.constraints.limits import AT_LIMIT
from jtik.symbolic.compile import CompiledFunction
from jtik.types import Array

STEPS = 50
"""Most steps."""

LONGEST = 0.3
"""Longest step [rad] or [m]."""

SHORTEST = 1e-9
"""Length of a step after which the method has arrived [rad] or [m]."""

FLAT = 1e-7
"""Eigenvalues of a Hessian below this fraction of the largest are zero: the levels below may move along them."""

STATIONARY = 1e-8
"""Gradient of the highest level, relative to |J| |r|, below which it is as near to its target as it can be."""


class LevelNewton:
    """Leads a configuration to where each level is as near to its target as those above it and the limits allow."""

    def __init__(self, problem: SymbolicProblem) -> None:
        self._problem = problem

    @cached_property
    def _curvatures(self) -> list[CompiledFunction]:
        problem, found = self._problem, []
        for k, rows in enumerate(problem.levels):
            build = partial(problem.curvature, rows)
            found.append(CompiledFunction(problem.once(f"curvature of level {k}", build)))
        return found

    def warm_up(self) -> None:
        """Build the functions now."""
        _ = self._curvatures

    def reach(self, q: Array, inputs: Inputs[Array]) -> bool:
        """Lead q there.

        Args:
            q: a configuration at which the highest level is not on its target, (nq,), changed in place.
            inputs: target, parameters and limits.

        Returns:
            Whether it has arrived; else q is as it was.
        """
        robot, at = self._problem.robot, q
        for _ in range(STEPS):
            step, stationary = self._step(at, inputs)
            length = float(np.linalg.norm(step))
            if not np.isfinite(length):
                return False
            at = np.asarray(robot.integrate(at, step * min(1.0, LONGEST / max(length, SHORTEST))))
            for i, _ in self._problem.scalar:
                at[i] = min(max(at[i], inputs.lower[i]), inputs.upper[i])
            if length <= SHORTEST:
                if stationary:
                    q[:] = at
                return stationary
        return False

    def scale(self, q: Array, inputs: Inputs[Array]) -> float:
        """|J| |r| of the highest level at q (nq,)."""
        return self._levels(q, inputs)[0][0]

    def _step(self, q: Array, inputs: Inputs[Array]) -> tuple[Array, bool]:
        """The step of all levels (n,), and whether the highest has a minimum at q."""
        n = self._problem.robot.n
        down, up = np.ones(n, dtype=bool), np.ones(n, dtype=bool)
        for i, j in self._problem.scalar:
            down[j], up[j] = q[i] > inputs.lower[i] + AT_LIMIT, q[i] < inputs.upper[i] - AT_LIMIT
        step, fixed, free = np.zeros(n), np.zeros(n, dtype=bool), np.eye(n)
        minimum = False
        for k, (scale, gradient, hessian) in enumerate(self._levels(q, inputs)):
            gradient_free = free @ (free.T @ (gradient + hessian @ step))
            outward = ~fixed & (
                (~down & (gradient_free > AT_LIMIT * scale)) | (~up & (gradient_free < -AT_LIMIT * scale))
            )
            if outward.any():  # these joints stay at their limits, for the levels below, too
                fixed |= outward
                free = _without(free, fixed)
            if not free.shape[1]:
                return step, minimum or k == 0
            values, vectors = np.linalg.eigh(free.T @ hessian @ free)
            largest = max(float(np.abs(values).max()), np.finfo(float).tiny)
            curved = np.abs(values) > FLAT * largest
            wanted = vectors.T @ (free.T @ (gradient + hessian @ step))
            if k == 0:
                minimum = bool(np.linalg.norm(wanted) <= STATIONARY * scale and values[0] > -FLAT * largest)
            step = step - free @ (vectors[:, curved] @ (wanted[curved] / np.abs(values[curved])))
            free = free @ vectors[:, ~curved]
        return step, minimum

    def _levels(self, q: Array, inputs: Inputs[Array]) -> list[tuple[float, Array, Array]]:
        """|J| |r|, gradient (n,) and Hessian (n, n) of V of each level."""
        found = []
        for function in self._curvatures:
            scale, gradient, hessian, _ = function(q, inputs.target, inputs.parameters)
            found.append((float(scale[0, 0]), gradient[:, 0].copy(), hessian.copy()))
        return found


def _without(free: Array, fixed: NDArray[np.bool_]) -> Array:
    """An orthonormal basis of the directions in the span of ``free`` (n, k) that do not move the fixed joints."""
    if not free.shape[1]:
        return free
    _, values, rows = np.linalg.svd(free[fixed], full_matrices=True)
    rank = int((values > FLAT).sum())
    remaining: Array = free @ rows[rank:].T
    return remaining
