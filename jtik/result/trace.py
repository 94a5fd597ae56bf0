"""The iterations of a solve."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jtik.types import Array


@dataclass(frozen=True)
class Trace:
    """The iterations of a solve. Row k belongs to the call of the step that started at ``q[k]``.

    Each figure can also be read as an attribute, such as ``trace.V``. All have shape (iterations,):

    - ``V``: the Lyapunov function of the task.
    - ``H``: the weighted sum of the criteria.
    - ``V2``: the Lyapunov function of the null-space motion (Das 1988).
    - ``alpha``, ``beta``: gains of the task step and of the null-space step; NaN for a strategy without such a gain.
    - ``predicted_decrease``, ``actual_decrease``: of V.
    - ``accepted``: 1 where the step was taken.
    - ``null_residual``: norm of the criterion's gradient in the null space of the task.
    - ``sigma_min``: smallest singular value of the weighted Jacobian of the joints that were free to move.
    - ``leakage``: ``|J nu| / |nu|`` of the null-space step nu; NaN where ``|nu|`` is below 1e-8.
    - ``step_length``: norm of the displacement [rad] and [m].
    - ``escaped``: 1 where the iteration ended in a saddle escape.
    - ``attempt``: 0 for the attempt from the caller's q0, then one more for each restart.
    - ``too_near``: with clearances, the largest amount by which a distance is below safe + margin [m].
    - ``task_share``: with clearances, the share of the task step that they allow: of its decrease of V in the model.
    - ``slack``: with elastic rows of a quadratic program, the largest amount by which one was relaxed.

    Attributes:
        q: configurations, (iterations + 1, nq); the last row is where the solve ended. In the rows before it, a joint
            that can turn all the way round may be outside its limits, by whole turns.
        error: norm of the task error at ``q[k]``, [m] and [rad] together, (iterations + 1,).
        figures: the figures above, by name.
    """

    q: Array
    error: Array
    figures: Mapping[str, Array]

    def __getattr__(self, name: str) -> Array:
        figures: Mapping[str, Array] = object.__getattribute__(self, "figures")
        if name in figures:
            return figures[name]
        raise AttributeError(f"a trace has q, error, {', '.join(figures)}; not {name!r}")

    def __len__(self) -> int:
        return len(self.q) - 1

    @property
    def answer_rows(self) -> NDArray[np.intp]:
        """The iterations of the attempt that led to where the solve ended; all of them without restarts.

        It is the one that ended nearest to there, whole turns apart.
        """
        attempts = self.figures.get("attempt", np.zeros(len(self)))
        last = np.flatnonzero(np.append(np.diff(attempts) != 0, True)) if len(self) else np.zeros(0, dtype=np.intp)
        if len(last) < 2:
            return np.arange(len(self))
        turned = np.exp(1j * self.q[last]) - np.exp(1j * self.q[-1])
        nearest = len(last) - 1 - int(np.argmin(np.abs(turned).sum(axis=1)[::-1]))
        return np.arange(0 if nearest == 0 else last[nearest - 1] + 1, last[nearest] + 1)

    def plot(self, **options: Any) -> Any:
        """A figure of the task error [m, rad], the criterion and the null-space residual by iteration.

        Example::

            solution = ik.solve(target, trace=True)
            solution.trace.plot().savefig("solve.pdf")

        Args:
            options: width [inch], that of `jtik.plotting.trace_figure`.

        Returns:
            A matplotlib Figure, which a notebook shows.

        Raises:
            ArgumentError: for a trace without an iteration.
            MissingExtraError: when matplotlib is not installed.
        """
        return import_module("jtik.plotting").trace_figure(self, **options)
