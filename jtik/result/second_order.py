"""The second-order condition of a stationary point of H: the direction of most negative curvature of the Lagrangian.

Over the motions v with J v = 0 that the limits allow. See formulations/second_order.md.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from jtik.types import Array

SecondOrder = Literal["minimum", "saddle", "flat"]
"""The kind of a stationary point of H, by the second derivatives."""

FLAT = 1e-6
"""An eigenvalue of the reduced Hessian below this fraction of the Hessian's norm counts as zero: q is no more exact."""

WRONG_SIGN = 1e-9
"""An entry of a unit direction counts as moving a joint beyond its limit from this size on."""


class LowestCurvature(NamedTuple):
    """The smallest curvature that was found.

    Attributes:
        value: z' W z; infinite where no motion is possible.
        direction: the unit vector z, (n,).
        scale: the norm of W.
        missing: orthonormal combinations of the task rows that no motion changes to first order, (m, k).
    """

    value: float
    direction: Array
    scale: float
    missing: Array

    @property
    def kind(self) -> SecondOrder:
        """The kind of the stationary point."""
        if abs(self.value) <= FLAT * self.scale:
            return "flat"
        return "minimum" if self.value > 0 else "saddle"


def lowest_curvature(W: Array, J: Array, free: NDArray[np.bool_], inward: Array, threshold: float) -> LowestCurvature:
    """The unit z with the smallest z' W z among those with J z = 0 that the limits allow.

    Joints inside their limits are considered first. Only where their lowest curvature is not negative, joints at a
    limit whose multiplier is zero are considered as well, each in the direction in which it can still move: from each
    direction of negative curvature, with either sign, the joint that it moves furthest beyond its limit is fixed, until
    none is left. That is exact with one such joint, and a heuristic with several.

    Args:
        W: Hessian of the Lagrangian, (n, n).
        J: Jacobian of the task, (m, n).
        free: joints inside their limits, (n,).
        inward: for a joint at a limit that may move away from it the sign of that motion, else 0, (n,).
        threshold: singular values of J up to this fraction of its norm count as zero.
    """
    best = _over(W, J, free, threshold)[0]
    if best.kind == "saddle" or not inward.any():
        return best
    for start in _over(W, J, free | (inward != 0), threshold):
        for sign in (1.0, -1.0):
            found, moving = start._replace(direction=sign * start.direction), free | (inward != 0)
            while found.value < 0 and (sizes := inward * found.direction).min() < -WRONG_SIGN:
                moving, before = moving & (np.arange(len(W)) != np.argmin(sizes)), found.direction
                found = _over(W, J, moving, threshold)[0]
                found = found._replace(direction=found.direction * (1.0 if before @ found.direction >= 0 else -1.0))
            if found.value < min(best.value, 0.0):
                best = found
    return best


def _over(W: Array, J: Array, moving: NDArray[np.bool_], threshold: float) -> list[LowestCurvature]:
    """The eigenvectors of W over the null space of J, for motions of some joints, by rising eigenvalue."""
    scale = float(np.linalg.norm(W, 2))
    left, sigma, rows = np.linalg.svd(J[:, moving])
    rank = int((sigma > threshold * np.linalg.norm(J[:, moving])).sum())
    null, missing = rows[rank:], left[:, rank:]
    if not len(null):
        return [LowestCurvature(np.inf, np.zeros(len(W)), scale, missing)]
    values, vectors = np.linalg.eigh(null @ W[np.ix_(moving, moving)] @ null.T)
    found = []
    for value, vector in zip(values.tolist(), vectors.T, strict=True):
        direction = np.zeros(len(W))
        direction[moving] = vector @ null
        found.append(LowestCurvature(value, direction, scale, missing))
    return found
