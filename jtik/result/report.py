"""Task and criteria at one configuration, as numbers: what a Solution shows."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jtik.result.length import length
from jtik.result.levels import Levels
from jtik.result.reduced_gradient import reduced_gradient
from jtik.result.relaxation import Relaxation
from jtik.result.second_order import FLAT, LowestCurvature, SecondOrder, lowest_curvature
from jtik.types import Array

STATIONARY = 1e-5
"""Relative gradient of the error of a level of priority up to which it cannot fall to first order."""


@dataclass(frozen=True, eq=False)
class Report:
    """Task and criteria at one configuration; whatever needs a factorisation is computed when it is first read.

    Attributes:
        error: task error e, (m,), rows in [m] or [rad].
        jacobian: Jacobian of the error with respect to the velocity, (m, n).
        linear: for each row, whether it is a length [m] rather than an angle [rad], (m,).
        residual: weighted task error, (m,).
        weighted: Jacobian of the residual, (m, n).
        values: weighted value of each criterion, by name.
        gradient: dH/dv, (n,).
        at_upper: velocity indices of the joints at their upper limit.
        at_lower: velocity indices of the joints at their lower limit.
        active_limits: names of the joints at a limit.
        tolerances: of position [m], orientation [rad] and optimality.
        rank_threshold: singular values of the weighted Jacobian up to this fraction of its norm count as zero.
        unused_part: what computes `unused`; None where there is no target to examine.
        curvature: multipliers lambda (m,) to the Hessian of H + lambda' r, (n, n); None without a criterion.
        relaxations: what computes `relaxed`; None for a strategy that relaxes nothing.
        close_pairs: what computes `active_clearances`; None without clearances.
        levels: the levels of priority, of a strategy that respects them; None for one level.
    """

    error: Array
    jacobian: Array
    linear: NDArray[np.bool_]
    residual: Array
    weighted: Array
    values: Mapping[str, float]
    gradient: Array
    at_upper: tuple[int, ...]
    at_lower: tuple[int, ...]
    active_limits: tuple[str, ...]
    tolerances: tuple[float, float, float]
    rank_threshold: float
    unused_part: Callable[[], str | None] | None = None
    curvature: Callable[[Array], Array] | None = None
    relaxations: Callable[[], tuple[Relaxation, ...]] | None = None
    close_pairs: Callable[[], tuple[str, ...]] | None = None
    levels: Levels | None = None

    def __getstate__(self) -> dict[str, Any]:
        # the results are pickled, the functions that compute them are not
        computed: dict[str, Any] = {"second_order": self.second_order, "relaxed": self.relaxed, "unused": self.unused}
        computed["active_clearances"] = self.active_clearances
        functions = ("curvature", "relaxations", "unused_part", "close_pairs")
        return {**vars(self), **computed, **dict.fromkeys(functions)}

    @cached_property
    def unused(self) -> str | None:
        """The part of the target that the tasks do not use, or None."""
        return self.unused_part() if self.unused_part else None

    @cached_property
    def position_error(self) -> float:
        """Norm of the position rows [m]."""
        return length(self.error[self.linear])

    @cached_property
    def orientation_error(self) -> float:
        """Norm of the orientation rows [rad]."""
        return length(self.error[~self.linear])

    @cached_property
    def relaxed(self) -> tuple[Relaxation, ...]:
        """What the strategy's first step from here relaxes, and what remains of tasks of a lower priority."""
        if not self.finite:
            return ()
        of_step = self.relaxations() if self.relaxations else ()
        return of_step + (self.levels.relaxed() if self.levels and self.prioritized else ())

    @property
    def prioritized(self) -> bool:
        """Whether higher levels of priority are reached and the others as near as those and the limits allow."""
        if self.levels is None or not 0 < self.levels.reached < len(self.levels.rows):
            return False
        return self.relative_gradient[1] <= STATIONARY

    @cached_property
    def active_clearances(self) -> tuple[str, ...]:
        """Names of the pairs whose distance is about as small as its clearance allows."""
        return self.close_pairs() if self.close_pairs else ()

    @property
    def reached(self) -> bool:
        """Whether both errors are within their tolerances."""
        return self.position_error <= self.tolerances[0] and self.orientation_error <= self.tolerances[1]

    @property
    def finite(self) -> bool:
        """Whether error, Jacobian, criteria and gradient are all finite numbers."""
        figures = (self.error, self.jacobian, self.gradient, np.array(list(self.values.values())))
        return all(bool(np.isfinite(figure).all()) for figure in figures)

    @cached_property
    def null_space_residual(self) -> float:
        """Norm of (I - J+ J) dH/dv over the joints whose limit is not active; NaN where something is not finite."""
        if not self.finite:
            return float("nan")
        free, reduced, _ = self._lagrangian
        return length(reduced[free])

    @property
    def stationary(self) -> bool:
        """Whether the null-space residual is within the optimality tolerance, relative to max(1, |dH/dv|)."""
        return self.null_space_residual <= self._small

    @property
    def _small(self) -> float:
        """The size up to which the gradient of the Lagrangian counts as zero."""
        return self.tolerances[2] * max(1.0, length(self.gradient))

    @cached_property
    def second_order(self) -> SecondOrder | None:
        """Kind of the stationary point, by the Hessian of H + lambda' r over motions that task and active limits allow.

        None without a criterion, off the target, or where H is not stationary.
        """
        lowest = self.lowest_curvature
        if lowest is None:
            return None
        return "flat" if lowest.kind == "saddle" and self._leaves_target(lowest) else lowest.kind

    @cached_property
    def lowest_curvature(self) -> LowestCurvature | None:
        """The direction of most negative curvature, from which `second_order` follows; None where that is None."""
        if self.curvature is None or not (self.finite and self.reached and self.stationary):
            return None
        _, reduced, multipliers = self._lagrangian
        hessian = self.curvature(multipliers)
        if not np.isfinite(hessian).all():
            return None
        inside = np.ones(len(reduced), dtype=bool)
        inside[[*self.at_upper, *self.at_lower]] = False
        inward = np.zeros(len(reduced))
        upper, lower = self._one_sided
        inward[[j for j in upper if reduced[j] >= -self._small]] = -1.0
        inward[[j for j in lower if reduced[j] <= self._small]] = 1.0
        return lowest_curvature(hessian, self.weighted, inside, inward, self.rank_threshold)

    def _leaves_target(self, lowest: LowestCurvature) -> bool:
        """Whether, at a singular pose, a motion along the direction leaves the target to second order."""
        if self.curvature is None or not lowest.missing.size:
            return False
        z, without = lowest.direction, self.curvature(np.zeros(len(self.weighted)))
        second = [z @ (self.curvature(combination) - without) @ z for combination in lowest.missing.T]
        return bool(np.linalg.norm(second) > FLAT * np.linalg.norm(self.weighted))

    @property
    def _one_sided(self) -> tuple[list[int], list[int]]:
        """Joints at their upper limit and at their lower limit, without those at both, which cannot move."""
        upper, lower = set(self.at_upper), set(self.at_lower)
        return sorted(upper - lower), sorted(lower - upper)

    @cached_property
    def _lagrangian(self) -> tuple[NDArray[np.bool_], Array, Array]:
        """Joints whose limit is not active, the gradient dH/dv + J' lambda, and the multipliers lambda.

        A joint at its limit that the gradient pushes outward keeps its limit active.
        """
        return reduced_gradient(self.weighted, self.gradient, self.at_upper, self.at_lower, self.rank_threshold)

    @property
    def relative_gradient(self) -> tuple[float, float]:
        """|J' r| / (|J| |r|) over all joints, and over those that no limit keeps from following -J' r.

        With levels of priority, that of the levels which are not reached, beside those above them.
        """
        if self.levels:
            return self.levels.relative_gradient()
        gradient = self.weighted.T @ (self.residual / (length(self.residual) or 1.0))
        scale = length(self.weighted) or 1.0
        return length(gradient) / scale, length(gradient[self.unblocked]) / scale

    @property
    def unblocked(self) -> NDArray[np.bool_]:
        """Joints that no limit keeps from following -J' r, (n,)."""
        gradient = self.weighted.T @ self.residual
        free = np.ones(len(gradient), dtype=bool)
        free[[j for j in self.at_upper if gradient[j] < 0] + [j for j in self.at_lower if gradient[j] > 0]] = False
        return free

    @property
    def multipliers(self) -> Array:
        """Multipliers lambda (m,) of the task in H: dH/dv + J' lambda is zero but for what limits take; unit of H per
        unit of the residual. NaN where something is not finite."""
        return self._lagrangian[2] if self.finite else np.full(len(self.residual), np.nan)
