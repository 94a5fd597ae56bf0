"""Task and criteria at one configuration, as numbers: what a Solution shows."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from jtik._step.relaxation import Relaxation
from jtik.symbolic.factorization import RANK_THRESHOLD
from jtik.types import Array

SecondOrder = Literal["minimum", "saddle", "flat"]
"""What the second derivatives say of a posture where H is stationary."""

FLAT = 1e-6
"""An eigenvalue of the reduced Hessian below this fraction of the whole's largest counts as zero: q is that exact."""


@dataclass(frozen=True, eq=False)
class Report:
    """Task and criteria at one configuration; what takes a factorisation is worked out when it is asked for.

    Attributes: error e (m,), its Jacobian (m, n), which rows are lengths; weighted residual (m,) and its Jacobian;
    values of the criteria by name; gradient dH/dv (n,); velocity indices of the joints at their upper and at their
    lower limit; names of all joints at a limit; the tolerances of position, orientation and optimality; the Hessian of
    H + lambda' r, as a function of lambda, where there is a criterion; what a step from there cannot have, to be worked
    out, where a strategy has anything that can give way.
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
    curvature: Callable[[Array], Array] | None = None
    yielded: Callable[[], tuple[Relaxation, ...]] | None = None

    def __getstate__(self) -> dict[str, Any]:
        # the answers travel, the functions they come from stay
        told = {"second_order": self.second_order, "relaxed": self.relaxed}
        return {**vars(self), **told, "curvature": None, "yielded": None}

    @cached_property
    def position_error(self) -> float:
        """Norm of the position rows [m]."""
        return float(np.linalg.norm(self.error[self.linear]))

    @cached_property
    def orientation_error(self) -> float:
        """Norm of the orientation rows [rad]."""
        return float(np.linalg.norm(self.error[~self.linear]))

    @cached_property
    def relaxed(self) -> tuple[Relaxation, ...]:
        """What a step from here asks for and cannot have."""
        return self.yielded() if self.yielded and self.finite else ()

    @property
    def reached(self) -> bool:
        """Whether both are within their tolerances."""
        return self.position_error <= self.tolerances[0] and self.orientation_error <= self.tolerances[1]

    @property
    def finite(self) -> bool:
        """Whether error, Jacobian, criteria and gradient are all finite numbers."""
        figures = (self.error, self.jacobian, self.gradient, np.array(list(self.values.values())))
        return all(bool(np.isfinite(figure).all()) for figure in figures)

    @cached_property
    def null_space_residual(self) -> float:
        """Norm of (I - J+ J) dH/dv over the joints that no limit holds; NaN where something is not finite."""
        if not self.finite:
            return float("nan")
        free, reduced, _ = self._settled()
        return float(np.linalg.norm(reduced[free]))

    @property
    def stationary(self) -> bool:
        """Whether that is within the optimality tolerance."""
        return self.null_space_residual <= self.tolerances[2] * max(1.0, float(np.linalg.norm(self.gradient)))

    @cached_property
    def second_order(self) -> SecondOrder | None:
        """Which kind of stationary: by the Hessian of H + lambda' r over the motions that keep task and active limits.

        None without a criterion, off the target, or where H is not stationary.
        """
        if self.curvature is None or not (self.finite and self.reached and self.stationary):
            return None
        free, _, multipliers = self._settled()
        bend, J = self.curvature(multipliers), self.weighted[:, free]
        if not np.isfinite(bend).all():
            return None
        _, sigma, rows = np.linalg.svd(J)
        rank = int((sigma > RANK_THRESHOLD * np.linalg.norm(J)).sum())
        null = rows[rank:]
        if not len(null):
            return "minimum"
        lowest = float(np.linalg.eigvalsh(null @ bend[np.ix_(free, free)] @ null.T)[0])
        scale = float(np.linalg.norm(bend, 2))
        if abs(lowest) <= FLAT * scale:
            return "flat"
        return "minimum" if lowest > 0 else "saddle"

    def _settled(self) -> tuple[NDArray[np.bool_], Array, Array]:
        """Joints that limits do not hold, the slope dH/dv + J' lambda, which presses the others out, and lambda."""
        J, gradient = self.weighted, self.gradient
        free = np.ones(J.shape[1], dtype=bool)
        free[[*self.at_upper, *self.at_lower]] = False
        reduced, multipliers = gradient, np.zeros(len(J))
        for _ in range(len(self.at_upper) + len(self.at_lower) + 1):
            multipliers = -np.linalg.pinv(J[:, free].T, rcond=RANK_THRESHOLD) @ gradient[free]
            reduced = gradient + J.T @ multipliers
            inward = [j for j in self.at_upper if not free[j] and reduced[j] > 0]
            inward += [j for j in self.at_lower if not free[j] and reduced[j] < 0]
            if not inward:
                break
            free[max(inward, key=lambda j: abs(reduced[j]))] = True
        return free, reduced, multipliers

    @property
    def flatness(self) -> tuple[float, float]:
        """|J' r| / (|J| |r|) over all joints, and over those that a limit does not keep from following -J' r."""
        force = self.weighted.T @ self.residual
        free = np.ones(len(force), dtype=bool)
        free[[j for j in self.at_upper if force[j] < 0] + [j for j in self.at_lower if force[j] > 0]] = False
        scale = float(np.linalg.norm(self.weighted) * np.linalg.norm(self.residual)) or 1.0
        return float(np.linalg.norm(force)) / scale, float(np.linalg.norm(force[free])) / scale
