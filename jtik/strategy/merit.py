"""The exact penalty H + mu |r| by which a step near the target is judged (formulations/merit.md)."""

from __future__ import annotations

from jtik.strategy.model import LocalModel, Point
from jtik.symbolic import Expression, fabs, fmax, fmin, logic_and, norm, ratio, sqrt

SUFFICIENT = 1e-4
"""Fraction of the predicted decrease an accepted step must bring (Armijo 1966)."""

ROUNDING = 1e-14
"""Relative error of an evaluated H, and of a residual beside the reach |J|: a smaller change says nothing."""

MOST = 100
"""How much a single step may raise the price above the least one."""


def penalty(
    model: LocalModel,
    before: Expression,
    slope: Expression,
    reach: Expression,
    lengths: tuple[Expression, Expression],
    H_after: Expression,
) -> Expression:
    """mu for a step, from the one before (M6).

    Args:
        slope: the decrease of H that it promises to first order.
        reach: the decrease of the error that it promises.
        lengths: of its task part and of all of it, squared.
        H_after: the criterion where it ends.
    """
    own, whole = lengths
    bend = ratio(2 * fmax(H_after - model.here.H + slope, 0), whole)
    least = 1.5 * norm(model.multipliers)
    least += (0.1 * model.gradient_length + bend * own**0.5) / model.jacobian_length
    needed = fmin(ratio(bend * own - slope, 0.5 * fmax(reach, 0)), MOST * least)
    return fmax(fmax(least, 0.5 * before), needed)


def reach_of(model: LocalModel, predicted: Expression) -> Expression:
    """By how much |r| falls where V falls by ``predicted``."""
    return model.here.length - sqrt(fmax(2 * (model.here.V - predicted), 0))


def outweighs(model: LocalModel, mu: Expression, point: Point, slope: Expression, reach: Expression) -> Expression:
    """Whether H + mu |r| falls on the way to ``point``, which stays in the tube (M5)."""
    here = model.here
    promised = mu * reach + slope
    merit, after = here.H + mu * here.length, point.H + mu * point.length
    noise = ROUNDING * (fabs(here.H) + fabs(merit) + mu * model.jacobian_length)
    better = logic_and(promised > -noise, merit - after >= SUFFICIENT * promised - noise)
    return logic_and(point.length <= model.tube, better)
