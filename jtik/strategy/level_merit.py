"""The exact penalty of several levels of priority as a merit function (formulations/lexicographic_qp.md)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from jtik.strategy.evaluation import Evaluation
from jtik.strategy.merit import LARGEST_INCREASE, ROUNDING, SUFFICIENT, Merit, Verdict, penalty_weight
from jtik.strategy.model import LocalModel
from jtik.symbolic import (
    TINY,
    Expression,
    dot,
    fabs,
    fmax,
    fmin,
    if_else,
    logic_and,
    norm,
    ratio,
    sqrt,
    sumsqr,
    vertcat,
    zeros,
)
from jtik.symbolic.factorization import damped_multipliers, squared_length
from jtik.types import Array

if TYPE_CHECKING:
    from jtik.strategy.base import Shape, State
    from jtik.strategy.programmed import Proposal

MULTIPLIER_DAMPING = 1e-6
"""Damping of the multipliers, relative to |J|^2: near singular poses only their order of magnitude is needed."""


class LevelMerit(Merit):
    """F = sum of w_k |r_k| over the levels k of priority; near the target H + mu F.

    The weight of each level exceeds the decrease that the levels below can gain by its error. With one level F is |r|.
    """

    def initial_state(self, shape: Shape) -> Mapping[str, Array]:
        """One weight for each row, because the number of levels is not known here, and mu.

        Args:
            shape: sizes of the problem.
        """
        return {"weights": np.zeros(shape.m), "penalty": np.zeros(1)}

    def verdict(self, model: LocalModel, state: State, proposal: Proposal, candidate: Evaluation) -> Verdict:
        """Armijo's test of F, or near the target of H + mu F."""
        null, step = proposal.null_space, proposal.task
        assert null is not None
        levels, r = model.levels, model.here.residual
        image = model.J @ step
        before = [norm(r[list(rows)]) for rows in levels]
        change = model.here.change(candidate)
        gains, falls_by = ([_shortened(r[list(rows)], by[list(rows)]) for rows in levels] for by in (image, change))
        lengths_of = [sqrt(squared_length(model.J[list(rows), :]) + TINY) for rows in levels]
        weights = _weights(model, state["weights"], gains, lengths_of)
        F, fall, predicted = (sum(w * v for w, v in zip(weights, of, strict=True)) for of in (before, falls_by, gains))
        falls = logic_and(predicted > 0, fall >= SUFFICIENT * predicted)
        gained = ratio(fall, fmax(predicted, 0))
        accepted, mu = falls, state["penalty"]
        if model.has_criterion:
            decrease = null.decrease - dot(model.gradient, step)
            lengths = (sumsqr(step), sumsqr(step + null.dq))
            mu = penalty_weight(model, mu, decrease, predicted, lengths, candidate.H)
            of_residual = sum(w * v for w, v in zip(weights, lengths_of, strict=True))
            noise = ROUNDING * (fabs(model.here.H) + fabs(model.here.H + mu * F) + mu * of_residual)
            total, actual = mu * predicted + decrease, model.here.H - candidate.H + mu * fall
            better = logic_and(total > -noise, actual >= SUFFICIENT * total - noise)
            inside = logic_and(candidate.length <= model.neighbourhood, better)
            accepted = if_else(model.near_target, inside, falls)
            gained = if_else(model.near_target, inside, gained)
        return Verdict(
            accepted=accepted,
            ratio=gained,
            state={"weights": _filled(vertcat(*weights), state["weights"].shape[0]), "penalty": mu},
            progress=ratio(fall, F) if len(levels) > 1 else None,
            predicted_decrease=model.predicted_decrease(image),
        )


def _shortened(r: Expression, change: Expression) -> Expression:
    """|r| - |r + change| without the rounding of two large numbers."""
    return ratio(-2 * dot(change, r + change / 2), norm(r) + norm(r + change))


def _weights(
    model: LocalModel, known: Expression, gains: Sequence[Expression], lengths: Sequence[Expression]
) -> list[Expression]:
    """Weights of the levels: 1 for the lowest; each above exceeds what the levels below can gain by its error.

    Args:
        model: the local model.
        known: the weights before.
        gains: predicted decrease of |r_k| of each level.
        lengths: Frobenius norm of the Jacobian of each level.
    """
    J, r, levels = model.J, model.here.residual, model.levels
    last = len(gains) - 1
    weights: list[Expression] = [1] * len(gains)
    gradient = zeros(J.shape[1])  # of the weighted sum of the levels below
    for k in reversed(range(last)):
        below = list(levels[k + 1])
        gradient = gradient + weights[k + 1] * ratio(J[below, :].T @ r[below], norm(r[below]))
        above = J[[row for rows in levels[: k + 1] for row in rows], :]
        multipliers = damped_multipliers(above, MULTIPLIER_DAMPING * squared_length(above), above @ gradient)
        own = multipliers[multipliers.shape[0] - len(levels[k]) :]
        floor = sum(weights[i] * lengths[i] for i in range(k + 1, last + 1)) / lengths[k]
        smallest = 1.5 * norm(own) + 0.5 * floor
        cost = sum(weights[i] * fmax(-gains[i], 0) for i in range(k + 1, last + 1))
        needed = fmin(ratio(2 * cost, fmax(gains[k], 0)), LARGEST_INCREASE * smallest)
        weights[k] = fmax(fmax(smallest, 0.5 * known[k]), needed)
    return weights


def _filled(column: Expression, rows: int) -> Expression:
    """The column with zeros below it."""
    filled = zeros(rows)
    filled[: column.shape[0]] = column
    return filled
