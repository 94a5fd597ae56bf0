"""The gain beta from the curvature along the last step, and the cap of null-space steps (projected_gradient.md, P2)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from jtik.strategy import LocalModel, NullSpaceDisplacement, Outcome, Shape, State
from jtik.symbolic import TINY, Expression, dot, fmax, fmin, if_else, is_symbolic, logic_and, norm, ratio, sqrt, sumsqr
from jtik.types import Array

SMALLEST_CHANGE = 1e-12
"""Change of grad H, relative to it, below which it is rounding and shows no curvature."""

SMALLEST_MOTION = 1e-12
"""Displacement [rad] up to which it is rounding and shows no curvature: y is then the change of live parameters."""

SHOWING_MOTION = 1e-11
"""Displacement [rad] that shows curvature."""

NO_STEP, STEP, NULL_STEP = 0.0, 1.0, 2.0
"""Kinds of the last step: there was none; a step; a step that was mostly a null-space step."""

UNBOUNDED = 1e30
"""A gain where H has no positive curvature along the step."""


@dataclass(frozen=True)
class BarzilaiBorweinGain:
    """The gain beta of the null-space gradient step, by Barzilai and Borwein, and its largest length.

    Attributes:
        step_limit: longest null-space step [rad].
        beta_max: the first gain; the unit of q^2 over that of H.
    """

    step_limit: float
    beta_max: float

    def initial_state(self, shape: Shape) -> Mapping[str, Array]:
        """The cap of a step, and the start, gradients and kind of the last one."""
        return {
            "null_cap": np.full(1, self.step_limit),
            "last_q": np.zeros(shape.nq),
            "last_H_gradient": np.zeros(shape.n),
            "last_null_gradient": np.zeros(shape.n),
            "last_kind": np.full(1, NO_STEP),
            "beta": np.full(1, self.beta_max),
        }

    def gain(self, model: LocalModel, state: State, null_gradient: Expression) -> Expression:
        """s's / s'y, s the displacement since the last step, y the change of the gradient with it (P2).

        If the last step was mostly a null-space step, y is the change of ``null_gradient`` (n, 1), and where H is not
        convex there is no bound. Otherwise y is that of grad H; where H is not convex the gain stays the same. So it
        does where q has not changed: at rest, a live parameter that changes must not leave a gain of almost nothing.
        In a solve it is then long enough to show the curvature: a shorter step would never change it.
        """
        change = model.coordinates.from_joints(model.robot.difference(state["last_q"], model.here.q))
        squared = sumsqr(change)
        of_null = dot(change, null_gradient - state["last_null_gradient"])
        of_all = dot(change, model.gradient - state["last_H_gradient"])
        significant = of_all > SMALLEST_CHANGE * sqrt(squared) * model.gradient_norm
        kind = if_else(squared > SMALLEST_MOTION**2, state["last_kind"], NO_STEP)
        before = state["beta"]
        if not model.timed:
            shows = ratio(SHOWING_MOTION, norm(null_gradient))
            before = if_else(squared > SMALLEST_MOTION**2, before, fmax(before, shows))
        kept = if_else(logic_and(kind == STEP, significant), squared / of_all, before)
        return if_else(kind == NULL_STEP, squared / fmax(of_null, squared / UNBOUNDED + TINY), kept)

    def adapt(
        self,
        model: LocalModel,
        state: State,
        null_gradient: Expression,
        proposed: NullSpaceDisplacement,
        outcome: Outcome,
    ) -> State:
        """The state after the step was accepted or refused."""
        cap, accepted, share = state["null_cap"], outcome.accepted, model.null_space_share
        shorter = if_else(outcome.shorten_null_space, fmin(_whole(outcome.null_space.length, share), cap) / 4, cap)
        return {
            "null_cap": if_else(accepted, fmin(2 * cap, self.step_limit), shorter),
            "beta": if_else(proposed.beta > 0, _whole(proposed.beta, share), state["beta"]),
            "last_q": model.here.q,
            "last_H_gradient": model.gradient,
            "last_null_gradient": null_gradient,
            "last_kind": if_else(logic_and(accepted, outcome.shorten_null_space), NULL_STEP, STEP),
        }


def _whole(taken: Expression, share: Expression) -> Expression:
    """What a step would take of which it takes a share; the value itself where that is 0."""
    return taken / if_else(share > 0, share, 1) if is_symbolic(share) else taken / share
