"""A Newton step of the task alone, from where a solve with a soft strategy ends: it tells what keeps the task off."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from jtik._step.symbolic_problem import SymbolicProblem
from jtik.result.report import Report
from jtik.types import Array

LEFT = 0.5
"""Largest share of the error that the step may leave: it leaves far less where only the criterion is in the way."""


class TaskAlone:
    """Newton's step of the task from a stationary point of the weighted sum of task error and criterion.

    The gradients of both are opposite there, whether the criterion keeps the task from its target, the target is out of
    reach, or limits are in the way. The step removes the error only in the first case.

    Args:
        problem: the problem.
        error: (q, target) -> the task error (m,).
    """

    def __init__(self, problem: SymbolicProblem, error: Callable[[Array, Array], Array]) -> None:
        self._robot, self._factor, self._error = problem.robot, problem.factor, error
        self._q_index = np.array([i for i, _ in problem.scalar], dtype=int)

    def reaches(
        self, found: Report, q: Array, target: Array, limits: tuple[Array, Array] | None = None
    ) -> Array | None:
        """Where the step ends, (nq,), if it removes most of the error; None if it does not.

        Args:
            found: the report of q.
            q: configuration at the start of the step, (nq,).
            target: target of the tasks.
            limits: lower and upper limits (nq,) that the step keeps to; None for none.
        """
        free: NDArray[np.bool_] = np.ones(found.weighted.shape[1], dtype=bool) if limits is None else found.unblocked
        dq = np.zeros(len(free))
        dq[free] = -np.linalg.pinv(found.weighted[:, free], rcond=found.rank_threshold) @ found.residual
        end = np.array(self._robot.integrate(q, dq), dtype=float)
        if limits is not None and self._q_index.size:
            lower, upper = limits
            end[self._q_index] = np.clip(end[self._q_index], lower[self._q_index], upper[self._q_index])
        left = np.linalg.norm(self._factor.T @ self._error(end, target))
        return end if left <= LEFT * np.linalg.norm(found.residual) else None
