"""Limits of a step: on its rotation, of each joint by a box or of the norm by scaling; joints pushed outward."""

from __future__ import annotations

import math

from jtik.constraints.limits import AT_LIMIT
from jtik.strategy.model import LocalModel
from jtik.symbolic import Expression, fmax, fmin, logic_and, logic_not, logic_or, ratio, vertcat


def limited_box(model: LocalModel, limit: float, share: Expression = 1) -> tuple[Expression, Expression]:
    """The box of the joint limits, (n, 1) each, in which no rotation is longer than ``limit`` [rad].

    Args:
        model: the local model.
        limit: largest rotation [rad].
        share: share of the displacement that is taken; the joint limits are those of this share.
    """
    low, high = (bound / share for bound in model.box)
    if not math.isfinite(limit):
        return low, high
    largest = [model.coordinates.entry(j, limit) if turns else math.inf for j, turns in enumerate(model.rotational)]
    return (
        vertcat(*[fmax(low[j], -angle) for j, angle in enumerate(largest)]),
        vertcat(*[fmin(high[j], angle) for j, angle in enumerate(largest)]),
    )


def within_step_limit(
    model: LocalModel, dq: Expression, limit: float, squared_length: Expression | None = None
) -> Expression:
    """The factor, at most 1, that brings the rotational part of ``dq`` (n, 1) down to ``limit`` [rad]; 1 if infinite.

    Scaling all entries alike keeps the direction of the displacement, and so that of the end effector.

    Args:
        model: the local model.
        dq: the displacement (n, 1).
        limit: longest rotation [rad].
        squared_length: squared norm of ``dq``, if it is known.
    """
    if not math.isfinite(limit):
        return 1
    return fmin(1, ratio(limit, model.rotation_norm(dq, squared_length)))


def not_outward(model: LocalModel, gradient: Expression) -> Expression:
    """0 for joints at a limit that the negative ``gradient`` (n, 1) pushes outward, else 1, (n, 1).

    Args:
        model: the local model.
        gradient: gradient of what the step lowers (n, 1).
    """
    low, high = model.box
    outward = [
        logic_or(logic_and(high[j] < AT_LIMIT, gradient[j] < 0), logic_and(low[j] > -AT_LIMIT, gradient[j] > 0))
        for j in range(model.robot.n)
    ]
    return vertcat(*[logic_not(out) for out in outward])
