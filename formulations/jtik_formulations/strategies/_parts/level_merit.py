"""When a step for tasks of several priorities is taken: an exact penalty (formulations/lexicographic_qp.md)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from jtik.strategy import LocalModel, NullMove, Point
from jtik.strategy.merit import penalty
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

SUFFICIENT = 1e-4
"""Fraction of the promised decrease an accepted step must bring (Armijo 1966)."""

ROUNDING = 1e-14
"""Relative error of an evaluated merit: a smaller change says nothing."""

MOST = 100
"""How much a single step may raise a weight above the least one."""


BLURRED = 1e-6
"""Damping of the prices, relative to |J|^2: near singular poses they need an order of magnitude, no digits."""


@dataclass(frozen=True)
class Verdict:
    """Whether a step is taken, and what to remember.

    Attributes: accepted; ratio of actual to promised decrease; progress, the decrease of F relative to what is left;
    weights of the levels (levels, 1); penalty of F against H.
    """

    accepted: Expression
    ratio: Expression
    progress: Expression
    weights: Expression
    penalty: Expression


@dataclass(frozen=True)
class LevelMerit:
    """F = sum of w_k |r_k|, each level worth more than those below can gain by it; near the target H + penalty F.

    Attributes: model; levels, the rows of each, the highest first.
    """

    model: LocalModel
    levels: Sequence[Sequence[int]]

    def judge(
        self, weights: Expression, before_mu: Expression, step: Expression, null: NullMove, point: Point
    ) -> Verdict:
        """Of a step ``step`` (n, 1) for the tasks with a null-space move, from the weights and penalty before."""
        model = self.model
        image = model.full_J @ step
        before = [norm(model.here.residual[list(rows)]) for rows in self.levels]
        after = [norm(point.residual[list(rows)]) for rows in self.levels]
        gains = [
            length - norm(model.here.residual[list(rows)] + image[list(rows)])
            for length, rows in zip(before, self.levels, strict=True)
        ]
        weighed = self._weights(weights, gains)
        F, F_after, promised = (sum(w * v for w, v in zip(weighed, of, strict=True)) for of in (before, after, gains))
        falls = logic_and(promised > 0, F - F_after >= SUFFICIENT * promised)
        progress = ratio(F - F_after, F)
        gained = ratio(F - F_after, fmax(promised, 0))
        if not model.has_criterion:
            return Verdict(falls, gained, progress, vertcat(*weighed), before_mu)
        slope = null.decrease - dot(model.full_gradient, step)
        mu = penalty(model, before_mu, slope, promised, (sumsqr(step), sumsqr(step - null.term)), point.H)
        phi, phi_after = model.here.H + mu * F, point.H + mu * F_after
        size = fabs(model.here.H) + fabs(phi)
        worth = mu * promised + slope
        better = logic_and(worth > 0, phi - phi_after >= SUFFICIENT * worth - ROUNDING * size)
        inside = logic_and(point.length <= model.tube, better)
        return Verdict(
            accepted=if_else(model.near, inside, falls),
            ratio=if_else(model.near, inside, gained),
            progress=progress,
            weights=vertcat(*weighed),
            penalty=mu,
        )

    def _weights(self, known: Expression, gains: Sequence[Expression]) -> list[Expression]:
        """1 for the lowest level; above it enough for what its error is worth to those below, lowest first."""
        J, r = self.model.full_J, self.model.here.residual
        lengths = [sqrt(squared_length(J[list(rows), :]) + TINY) for rows in self.levels]
        last = len(gains) - 1
        weights: list[Expression] = [1] * len(gains)
        pull = zeros(J.shape[1])
        for k in reversed(range(last)):
            below = list(self.levels[k + 1])
            pull = pull + weights[k + 1] * ratio(J[below, :].T @ r[below], norm(r[below]))
            above = J[[row for rows in self.levels[: k + 1] for row in rows], :]
            prices = damped_multipliers(above, BLURRED * squared_length(above), above @ pull)
            own = prices[prices.shape[0] - len(self.levels[k]) :]
            floor = sum(weights[i] * lengths[i] for i in range(k + 1, last + 1)) / lengths[k]
            least = 1.5 * norm(own) + 0.5 * floor
            cost = sum(weights[i] * fmax(-gains[i], 0) for i in range(k + 1, last + 1))
            needed = fmin(ratio(2 * cost, fmax(gains[k], 0)), MOST * least)
            weights[k] = fmax(fmax(least, 0.5 * known[k]), needed)
        return weights
