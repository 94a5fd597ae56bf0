"""Limits on the rotation of a step: of each joint by a box, or of the norm by scaling the step."""

from __future__ import annotations

import math

from jtik.strategy.model import LocalModel
from jtik.symbolic import Expression, fmax, fmin, ratio, vertcat


def limited_box(model: LocalModel, limit: float) -> tuple[Expression, Expression]:
    """The box of the joint limits, (n, 1) each, in which no rotation is longer than ``limit`` [rad]."""
    low, high = model.box
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
    """
    if not math.isfinite(limit):
        return 1
    return fmin(1, ratio(limit, model.rotation_norm(dq, squared_length)))
