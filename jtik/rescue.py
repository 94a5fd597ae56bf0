"""The way out of an exact singular stall: a second-order step where the first derivative of V says nothing.

A straight arm with its target on its own line feels no torque: J' r = 0 with r != 0. Whether that is a closest
posture or a saddle, the Hessian of V tells; along its most negative eigenvector V falls to second order.
Deterministic: no noise is added.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from jtik.compile import Compiled
from jtik.limits import AT_LIMIT
from jtik.problem import Problem
from jtik.symbolic import function, sumsqr, symbol

Array = NDArray[np.float64]

FIRST_STEP = 0.5
"""Length of the first step tried along the eigenvector [rad]; halved until V falls."""

HALVINGS = 20

NEGATIVE = 1e-9
"""An eigenvalue counts as negative below this fraction of the largest magnitude."""

WORTH = 1e-9
"""Least relative decrease of V that counts as a way out."""


class Rescue:
    """Second-order looks at V, compiled when first needed."""

    def __init__(self, problem: Problem) -> None:
        self._problem = problem

    @cached_property
    def _curvature(self) -> Compiled:
        return Compiled(self._problem.curvature())

    @cached_property
    def _moved(self) -> Compiled:
        """(q, v, target) -> q + v and V there."""
        q, target, _ = self._problem.symbols()
        v = symbol("v", self._problem.robot.n)
        there = self._problem.robot.integrate(q, v)
        V = sumsqr(self._problem.residual(there, target)) / 2
        return Compiled(function("moved", [q, v, target], [there, V]))

    def lowest_curvature(self, q: Array, inputs: Sequence[Array]) -> tuple[float, Array, Array]:
        """Relative lowest eigenvalue of d2V/dv2 over joints not at a limit, its eigenvector (n,), and dH/dv (n,)."""
        target, parameters, lower, upper, _ = inputs
        _, _, bend, criterion = self._curvature(q, target, parameters)
        inside = np.ones(self._problem.robot.n, dtype=bool)
        for i, j in self._problem.bounded:
            inside[j] = lower[i] + AT_LIMIT < q[i] < upper[i] - AT_LIMIT
        vector = np.zeros(self._problem.robot.n)
        if not inside.any() or not np.isfinite(bend).all():
            return 0.0, vector, criterion
        values, vectors = np.linalg.eigh(bend[np.ix_(inside, inside)])
        scale = max(np.abs(values).max(), np.finfo(float).tiny)
        vector[inside] = vectors[:, 0]
        return float(values[0] / scale), vector, criterion

    def escape(self, q: Array, inputs: Sequence[Array]) -> bool:
        """Leave a saddle of V: move ``q`` in place and return True, or return False if V is least here."""
        target, _, lower, upper, _ = inputs
        lowest, vector, criterion = self.lowest_curvature(q, inputs)
        if lowest > -NEGATIVE:
            return False
        slope = float(criterion @ vector)
        if abs(slope) > 1e-9 * np.linalg.norm(criterion):
            vector = -np.sign(slope) * vector
        elif vector[np.argmax(np.abs(vector))] < 0:
            vector = -vector
        before = float(self._moved(q, 0 * vector, target)[1][0])
        step = FIRST_STEP * vector
        for _ in range(HALVINGS):
            for sign in (1.0, -1.0):
                there, V = self._moved(q, sign * step, target)
                allowed = all(lower[i] <= there[i] <= upper[i] for i, _ in self._problem.bounded)
                if allowed and V[0] < (1 - WORTH) * before:
                    q[:] = there
                    return True
            step /= 2
        return False
