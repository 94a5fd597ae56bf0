"""The gradient that the rows of a task and the active limits leave."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray

from jtik.result.length import length
from jtik.types import Array

ROUNDING = 1e-13
"""Outward part of the reduced gradient, relative to the gradient, up to which a limit is not worth another pass."""

PASSES = 4
"""Passes for each joint at a limit; more than about two are never needed without rounding."""


def reduced_gradient(
    J: Array, gradient: Array, at_upper: Collection[int], at_lower: Collection[int], rank_threshold: float
) -> tuple[NDArray[np.bool_], Array, Array]:
    """The joints whose limit is not active, the gradient + J' lambda, and the multipliers lambda.

    Over the joints whose limit is not active, the gradient + J' lambda is as short as multipliers lambda of the rows
    and non-negative ones of the limits make it. Its length is the rate at which the function falls along the steepest
    motion that rows and limits allow to first order (formulations/joint_limits.md). A joint at both limits cannot move.

    Args:
        J: Jacobian of the rows that are kept, (m, n).
        gradient: gradient, (n,).
        at_upper: joints at their upper limit.
        at_lower: joints at their lower limit.
        rank_threshold: singular values of J up to this fraction of its norm count as zero.

    Source: Lawson and Hanson, *Solving Least Squares Problems*, chapter 23, begun with every limit active.
    """
    upper, lower = set(at_upper) - set(at_lower), set(at_lower) - set(at_upper)
    sides = dict.fromkeys(sorted(upper), 1.0) | dict.fromkeys(sorted(lower), -1.0)
    free = np.ones(len(gradient), dtype=bool)
    free[[*at_upper, *at_lower]] = False
    least, of_limits = ROUNDING * length(gradient), dict.fromkeys(sides, 0.0)
    reduced, multipliers = _fit(J, gradient, free, rank_threshold)
    for _ in range(PASSES * len(sides)):
        wanted = {j: -side * reduced[j] for j, side in sides.items() if not free[j]}
        shares = {j: of_limits[j] / (of_limits[j] - new) for j, new in wanted.items() if new < 0}
        if shares:  # as far as no multiplier becomes negative; limits whose multiplier is then zero are released
            share = min(shares.values())
            of_limits |= {j: of_limits[j] + share * (new - of_limits[j]) for j, new in wanted.items()}
            leaving = [j for j, own in shares.items() if own <= share]
            free[leaving] = True
            of_limits |= dict.fromkeys(leaving, 0.0)
        else:
            of_limits |= wanted
            outward = {j: -side * reduced[j] for j, side in sides.items() if free[j]}
            entering = max(outward, key=outward.__getitem__, default=None)
            if entering is None or outward[entering] <= least:
                break
            free[entering] = False
        reduced, multipliers = _fit(J, gradient, free, rank_threshold)
    return free, reduced, multipliers


def _fit(J: Array, gradient: Array, free: NDArray[np.bool_], rank_threshold: float) -> tuple[Array, Array]:
    """The gradient + J' lambda, and the multipliers lambda with which it is shortest over the free joints."""
    multipliers = -np.linalg.pinv(J[:, free].T, rcond=rank_threshold) @ gradient[free]
    return gradient + J.T @ multipliers, multipliers
