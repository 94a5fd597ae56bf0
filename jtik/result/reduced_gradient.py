"""The gradient that the rows of a task and the active limits leave."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray

from jtik.types import Array


def reduced_gradient(
    J: Array, gradient: Array, at_upper: Collection[int], at_lower: Collection[int], rank_threshold: float
) -> tuple[NDArray[np.bool_], Array, Array]:
    """The joints whose limit is not active, the gradient + J' lambda, and the multipliers lambda.

    The gradient over those joints is its part in the null space of J. A joint at its limit that the negative gradient
    pushes outward keeps its limit active, and one at both limits cannot move.

    Args:
        J: Jacobian of the rows that are kept, (m, n).
        gradient: gradient, (n,).
        at_upper: joints at their upper limit.
        at_lower: joints at their lower limit.
        rank_threshold: singular values of J up to this fraction of its norm count as zero.
    """
    free = np.ones(len(gradient), dtype=bool)
    free[[*at_upper, *at_lower]] = False
    upper, lower = sorted(set(at_upper) - set(at_lower)), sorted(set(at_lower) - set(at_upper))
    reduced, multipliers = gradient, np.zeros(len(J))
    for _ in range(len(upper) + len(lower) + 1):
        multipliers = -np.linalg.pinv(J[:, free].T, rcond=rank_threshold) @ gradient[free]
        reduced = gradient + J.T @ multipliers
        inward = [j for j in upper if not free[j] and reduced[j] > 0]
        inward += [j for j in lower if not free[j] and reduced[j] < 0]
        if not inward:
            break
        free[max(inward, key=lambda j: abs(reduced[j]))] = True
    return free, reduced, multipliers
