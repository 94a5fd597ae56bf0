"""The saddle escape: a step along a direction of negative curvature of V, from a pose where its gradient is zero.

At a straight arm whose target lies on its own line, J' r = 0 with r != 0. The Hessian of V shows whether that is a
minimum or a saddle point; along its most negative eigenvector V falls to second order. The escape is deterministic: no
noise is added. It keeps limits and clearances, as any step does. See formulations/singular_escape.md.
"""

from __future__ import annotations

import math
import threading
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from jtik._step.clearances import clearance_model
from jtik._step.inputs import Inputs
from jtik._step.symbolic_problem import SymbolicProblem
from jtik.constraints.limits import AT_LIMIT
from jtik.symbolic import Function, function, sumsqr, symbol
from jtik.symbolic.compile import CompiledFunction
from jtik.types import Array

FIRST_STEP = 0.5
"""Length of the first step tried along the eigenvector [rad]; halved until V falls."""

HALVINGS = 20
"""Maximum number of times that the first step is halved."""

PROJECTIONS = 100
"""Projected power iterations for the direction of most negative curvature among those that limits allow."""

FLAT = 1e-5
"""|J' r| / (|J| |r|) below which the error cannot fall to first order."""

NEGATIVE = 1e-9
"""An eigenvalue counts as negative below this fraction of the largest magnitude."""

MINIMUM_DECREASE = 1e-12
"""Smallest relative decrease of V for which an escape is made: small, because the box of a timed step may be."""


class SaddleEscape:
    """Curvature of V and the escape along it; the functions are built when first needed, or by `warm_up`."""

    def __init__(self, problem: SymbolicProblem) -> None:
        self._problem = problem
        self._lock = threading.Lock()  # a status is computed when it is read, perhaps while another thread solves

    @cached_property
    def _curvature(self) -> CompiledFunction:
        return CompiledFunction(self._problem.once("curvature", self._problem.curvature))

    @cached_property
    def _highest_level(self) -> CompiledFunction:
        problem = self._problem
        build = partial(problem.curvature, problem.levels[0])
        return CompiledFunction(problem.once("curvature of the highest level", build))

    @cached_property
    def _moved(self) -> CompiledFunction:
        return CompiledFunction(self._problem.once("moved", self._moved_function))

    def _moved_function(self) -> Function:
        """(q, v, target) -> q + v and V at it."""
        q, target, _ = self._problem.symbols()
        v = symbol("v", self._problem.robot.n)
        moved_q = self._problem.robot.integrate(q, v)
        V = sumsqr(self._problem.residual(moved_q, target)) / 2
        return function("moved", [q, v, target], [moved_q, V], cse=False)

    @cached_property
    def _clearances_hold(self) -> CompiledFunction:
        return CompiledFunction(self._problem.once("clearances_hold", self._clearances_hold_function))

    def _clearances_hold_function(self) -> Function:
        """(q, v, parameters, lower, upper) -> 1 where clearances hold all the way from q to q + v."""
        problem = self._problem
        q, _, parameters = problem.symbols()
        v = symbol("v", problem.robot.n)
        limits = symbol("lower", problem.robot.nq), symbol("upper", problem.robot.nq)
        model = clearance_model(problem, q, problem.measured.clearance(q, parameters), parameters, limits)
        keeps = model.keeps(problem.coordinates.from_joints(v))
        return function("clearances_hold", [q, v, parameters, *limits], [keeps])

    def warm_up(self) -> None:
        """Build the functions now."""
        _ = self._curvature, self._moved
        if self._problem.clearances:
            _ = self._clearances_hold

    def lowest_curvature(self, q: Array, inputs: Inputs[Array], flat: float = FLAT) -> tuple[float, Array, Array]:
        """The direction of most negative curvature of V that the limits allow.

        Joints inside their limits are considered first. Only where their lowest eigenvalue is not negative are joints
        at a limit considered as well that V does not push outward, each in the direction in which it can still move; a
        joint that V pushes outward would raise V to first order. Where V can fall to first order, the curvature
        returned is 0, because no escape is needed.

        Args:
            q: configuration, (nq,).
            inputs: target, parameters and limits.
            flat: |J' r| / (|J| |r|) up to which the error cannot fall to first order.

        Returns:
            v' (d2V/dv2) v relative to the largest eigenvalue; the unit direction v, (n,); and dH/dv, (n,).
        """
        lower, upper = inputs.lower, inputs.upper
        with self._lock:
            scale, gradient, hessian, criterion = self._curvature(q, inputs.target, inputs.parameters)
        n = self._problem.robot.n
        down, up = np.ones(n, dtype=bool), np.ones(n, dtype=bool)
        for i, j in self._problem.scalar:
            down[j], up[j] = q[i] > lower[i] + AT_LIMIT, q[i] < upper[i] - AT_LIMIT
        lowest, best = 0.0, np.zeros(n)
        outward = (~down & (gradient[:, 0] > 0)) | (~up & (gradient[:, 0] < 0))
        stationary = np.linalg.norm(gradient[~outward]) <= flat * scale[0, 0]
        if not (np.isfinite(hessian).all() and stationary):
            return lowest, best, criterion[:, 0]
        values, vectors = np.linalg.eigh(hessian)
        hessian /= max(float(np.abs(values).max()), np.finfo(float).tiny)
        inside = down & up
        if inside.any():
            inner_values, inner_vectors = np.linalg.eigh(hessian[np.ix_(inside, inside)])
            lowest, best[inside] = float(inner_values[0]), inner_vectors[:, 0]
        unpushed = ~inside & (np.abs(gradient[:, 0]) <= flat * scale[0, 0])
        if lowest <= -NEGATIVE or not unpushed.any():
            return lowest, best, criterion[:, 0]
        fixed = ~inside & ~unpushed
        for start in vectors[:, values < 0].T:
            for sign in (1.0, -1.0):
                v = _descend(hessian, sign * start, down & ~fixed, up & ~fixed)
                if v @ hessian @ v < lowest:
                    lowest, best = float(v @ hessian @ v), v
        return lowest, best, criterion[:, 0]

    def possible_decrease(self, q: Array, inputs: Inputs[Array], *, highest_level: bool = False) -> float:
        """How much V can fall within 1 rad along each direction, by its gradient and its Hessian.

        Joints at a limit that V pushes outward stay where they are.

        Args:
            q: configuration, (nq,).
            inputs: target, parameters and limits.
            highest_level: whether V is that of the highest level of priority alone.
        """
        with self._lock:
            curvature = self._highest_level if highest_level else self._curvature
            _, gradient, hessian, _ = curvature(q, inputs.target, inputs.parameters)
        free = np.ones(self._problem.robot.n, dtype=bool)
        for i, j in self._problem.scalar:
            at_upper, at_lower = q[i] >= inputs.upper[i] - AT_LIMIT, q[i] <= inputs.lower[i] + AT_LIMIT
            free[j] = not ((at_upper and gradient[j, 0] < 0) or (at_lower and gradient[j, 0] > 0))
        if not np.isfinite(hessian).all():
            return math.inf
        values, vectors = np.linalg.eigh(hessian[np.ix_(free, free)])
        components = np.abs(vectors.T @ gradient[free, 0])
        lengths = np.ones(len(values))
        np.divide(components, values, out=lengths, where=values > components)
        return float(lengths @ components - lengths**2 @ values / 2)

    def escape(self, q: Array, inputs: Inputs[Array]) -> bool:
        """Move q away from a saddle point of V.

        Args:
            q: configuration, (nq,), changed in place.
            inputs: target, parameters and limits.

        Returns:
            Whether ``q`` was changed: False at a minimum of V.
        """
        target, lower, upper = inputs.target, inputs.lower, inputs.upper
        lowest, vector, criterion = self.lowest_curvature(q, inputs)
        if lowest > -NEGATIVE:
            return False
        rate = float(criterion @ vector)
        if abs(rate) > 1e-9 * np.linalg.norm(criterion):
            vector = -np.sign(rate) * vector
        elif vector[np.argmax(np.abs(vector))] < 0:
            vector = -vector
        before = float(self._moved(q, 0 * vector, target)[1][0, 0])
        step = FIRST_STEP * vector
        for _ in range(HALVINGS):
            for sign in (1.0, -1.0):
                moved_q, V = self._moved(q, sign * step, target)
                allowed = all(lower[i] <= moved_q[i, 0] <= upper[i] for i, _ in self._problem.scalar)
                falls = allowed and V[0, 0] < (1 - MINIMUM_DECREASE) * before
                if falls and self.clear(q, sign * step, inputs):
                    q[:] = moved_q[:, 0]
                    return True
            step /= 2
        return False

    def clear(self, q: Array, v: Array, inputs: Inputs[Array]) -> bool:
        """Whether clearances, if there are any, hold on the way from q to q + v."""
        if not self._problem.clearances:
            return True
        return bool(self._clearances_hold(q, v, inputs.parameters, inputs.lower, inputs.upper)[0][0, 0])


def _descend(hessian: Array, v: Array, down: NDArray[np.bool_], up: NDArray[np.bool_]) -> Array:
    """Minimise v' hessian v from v on the unit sphere, within the signs that limits allow; the hessian's norm is 1."""
    for _ in range(PROJECTIONS):
        v = v - hessian @ v
        v = np.where(((v < 0) & ~down) | ((v > 0) & ~up), 0.0, v)
        length = float(np.linalg.norm(v))
        if length == 0.0:
            return v
        v = v / length
    return v
