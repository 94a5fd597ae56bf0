"""Why a solve stopped: from the last configuration and the fused function's code to a Status."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from jtik.compile import Compiled
from jtik.factorization import RANK_THRESHOLD
from jtik.fused import Code
from jtik.limits import AT_LIMIT
from jtik.problem import Problem
from jtik.rescue import NEGATIVE, Rescue
from jtik.solution import Status

Array = NDArray[np.float64]

FLAT = 1e-5
"""|J' r| / (|J| |r|) below which the error cannot fall to first order."""


@dataclass(frozen=True)
class Report:
    """Task and criteria at one configuration, with what may still move there.

    Attributes: error (m,), its norms by kind, jacobian (m, n), values of the criteria, gradient of H (n,), active
    limits by joint name, free joints (n,), whether the target is reached and H steady, and the flatness of V over
    all and over the free joints.
    """

    error: Array
    position_error: float
    orientation_error: float
    jacobian: Array
    values: Array
    gradient: Array
    null_residual: float
    active_limits: tuple[str, ...]
    reached: bool
    steady: bool
    flatness: float
    free_flatness: float


class Diagnosis:
    """Looks at where a solve ended."""

    def __init__(self, problem: Problem, rescue: Rescue) -> None:
        self._problem, self._rescue = problem, rescue
        self._evaluate = Compiled(problem.report())
        self._error = Compiled(problem.error)

    def report(self, q: Array, inputs: Sequence[Array]) -> Report:
        """Everything a Solution tells of the configuration q."""
        target, parameters, lower, upper, settings = inputs
        error, jacobian, values, gradient, residual, weighted = self._evaluate(q, target, parameters)
        linear = np.array(self._problem.linear)
        position, orientation = float(np.linalg.norm(error[linear])), float(np.linalg.norm(error[~linear]))
        at_upper = [j for i, j in self._problem.bounded if q[i] >= upper[i] - AT_LIMIT]
        at_lower = [j for i, j in self._problem.bounded if q[i] <= lower[i] + AT_LIMIT]
        reached = bool(position <= settings[0] and orientation <= settings[1])
        force = weighted.T @ residual
        everything = np.ones(self._problem.robot.n, dtype=bool)
        free = everything.copy()
        if reached:
            free, reduced = self._settled(weighted, gradient, at_upper, at_lower)
        else:
            reduced = force
            free[[j for j in at_upper if force[j] < 0] + [j for j in at_lower if force[j] > 0]] = False
        null = float(np.linalg.norm(reduced[free])) if reached else _null_residual(weighted, gradient)
        scale = float(np.linalg.norm(weighted) * np.linalg.norm(residual)) or 1.0
        robot = self._problem.robot
        names = {robot.v_slice(name).start: name for name in robot.joint_names}
        return Report(
            error=error,
            position_error=position,
            orientation_error=orientation,
            jacobian=jacobian,
            values=values,
            gradient=gradient,
            null_residual=null,
            active_limits=tuple(names[j] for j in sorted({*at_upper, *at_lower})),
            reached=reached,
            steady=bool(null <= settings[2] * max(1.0, float(np.linalg.norm(gradient)))),
            flatness=float(np.linalg.norm(force)) / scale,
            free_flatness=float(np.linalg.norm(force[free])) / scale,
        )

    def error(self, q: Array, inputs: Sequence[Array]) -> Array:
        """The task error at q, (m,)."""
        return self._error(q, inputs[0])[0]

    @staticmethod
    def _settled(
        J: Array, gradient: Array, at_upper: list[int], at_lower: list[int]
    ) -> tuple[NDArray[np.bool_], Array]:
        """Joints that limits do not hold, and the reduced gradient dH/dv + J' lambda, which presses held ones out."""
        free = np.ones(J.shape[1], dtype=bool)
        free[[*at_upper, *at_lower]] = False
        for _ in range(len(at_upper) + len(at_lower) + 1):
            multipliers = -np.linalg.pinv(J[:, free].T, rcond=RANK_THRESHOLD) @ gradient[free]
            reduced = gradient + J.T @ multipliers
            inward = [j for j in at_upper if not free[j] and reduced[j] > 0]
            inward += [j for j in at_lower if not free[j] and reduced[j] < 0]
            if not inward:
                break
            free[max(inward, key=lambda j: abs(reduced[j]))] = True
        return free, reduced

    def status(self, q: Array, code: Code, report: Report, inputs: Sequence[Array]) -> Status:
        """The reason, in the order a user would ask for it."""
        if code is Code.NOT_FINITE:
            return Status.NOT_FINITE
        if report.reached:
            return Status.CONVERGED if report.steady else Status.REACHED
        if code is Code.GO_ON:
            return Status.ITERATION_LIMIT
        if report.flatness > FLAT:
            return Status.LIMITS if report.free_flatness <= FLAT else Status.STALLED
        lowest, _, _ = self._rescue.lowest_curvature(q, inputs)
        return Status.LOCAL_MINIMUM if lowest > -NEGATIVE else Status.SINGULAR


def _null_residual(J: Array, gradient: Array) -> float:
    return float(np.linalg.norm(gradient - np.linalg.pinv(J, rcond=RANK_THRESHOLD) @ (J @ gradient)))
