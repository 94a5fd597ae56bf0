"""Strategies that shorten a task in its direction until the step fits into the limits (formulations/sns.md)."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np

from jtik._step.active_set import AT_LIMIT
from jtik.errors import ArgumentError
from jtik.strategy import Acceptance, LocalModel, NullMove, Outcome, Shape, State, Strategy, Update
from jtik.symbolic import (
    Expression,
    diag,
    dot,
    fmin,
    if_else,
    is_finite,
    logic_and,
    logic_not,
    logic_or,
    norm,
    ratio,
    sumsqr,
    vertcat,
    zeros,
)
from jtik.symbolic.factorization import RowSpace, damped_multipliers
from jtik.types import Array
from jtik_formulations.strategies._parts.level_merit import LevelMerit
from jtik_formulations.strategies.projected_gradient import NOISE, ProjectedGradient
from jtik_formulations.strategies.weighted_qp import capped


class Scaled(Protocol):
    """A displacement within a box, to which one task after the other is added, and at last a wish."""

    @property
    def x(self) -> Expression:
        """The displacement (n, 1)."""

    @property
    def scale(self) -> Expression:
        """The share of the last task that fitted, 0 to 1."""

    def with_task(self, J: Expression, change: Expression) -> Scaled:
        """J x changes by a share of ``change`` (m, 1); J x of the tasks before does not."""

    def towards(self, wish: Expression) -> Scaled:
        """x comes nearer to ``wish`` (n, 1); J x of all tasks stays."""


@dataclass(frozen=True, kw_only=True)
class TaskScaling(Strategy):
    """What the laws with task scaling share: which task they are given, the box, the criterion and the verdict."""

    gain: float = 1.0
    damping: float = 0.1
    q_limit: float = 0.5
    backtracking: bool = True
    secondary: ProjectedGradient = field(default_factory=ProjectedGradient)

    def __post_init__(self) -> None:
        if not 0 < self.gain <= 1:
            raise ArgumentError("gain", self.gain, "a number in (0, 1]")
        if not 0 <= self.damping < math.inf:
            raise ArgumentError("damping", self.damping, "a finite number from 0")
        if not self.q_limit > 0:
            raise ArgumentError("q_limit", self.q_limit, "a positive angle [rad], math.inf for none")
        if type(self.secondary) is not ProjectedGradient or self.secondary.rule != "merit":
            raise ArgumentError("secondary", self.secondary, "a ProjectedGradient(rule='merit'), whose gain is used")

    @abstractmethod
    def at_rest(self, model: LocalModel, lower: Expression, upper: Expression) -> Scaled:
        """No displacement yet, in this box (n, 1) each."""

    def releases(self) -> bool:
        """Whether ``towards`` takes joints off their bounds; if not, the engine's working set does."""
        return True

    def acceptance(self) -> Acceptance:
        """``"merit"``: the penalty function falls, which for one level is V; ``"always"`` without backtracking."""
        return "merit" if self.backtracking else "always"

    def evaluates_candidate(self, has_criterion: bool) -> bool:
        """With backtracking, or for the criterion's own step length."""
        return self.backtracking or has_criterion

    def initial_state(self, shape: Shape) -> Mapping[str, Array]:
        """Fraction of the step, weights of the levels, penalty, and what the criterion's gain remembers."""
        state = {"fraction": np.ones(1), "weights": np.zeros(shape.m), "penalty": np.zeros(1)}
        if shape.has_criterion:
            state |= self.secondary.initial_state(shape)
        return state

    def update(self, model: LocalModel, state: State) -> Update:
        """All levels, the criterion, the verdict."""
        fraction = state["fraction"] if self.backtracking else 1
        here, unlimited, shares = self._tasks(model, self.at_rest(model, *capped(model, self.q_limit)))
        step = fraction * here.x
        null = proposed = NullMove(zeros(model.robot.n), 0, 0, 0)
        if model.has_criterion:
            proposed, wish = self._null_move(model, state, here)
            null = replace(
                proposed,
                term=fraction * proposed.term,
                length=fraction * proposed.length,
                decrease=fraction * proposed.decrease,
                beta=fraction * proposed.beta,
            )
            unlimited = unlimited + wish
        term = model.within_limits(null.term - step)
        point = model.moved(term)
        verdict = LevelMerit(model, model.levels).judge(state["weights"], state["penalty"], step, null, point)
        accepted = verdict.accepted if self.backtracking else 1
        accepted = logic_and(
            accepted, is_finite(point.V + point.H if self.evaluates_candidate(model.has_criterion) else term)
        )
        clear = model.clearance.keeps(term) if model.clearance else 1
        accepted = logic_and(accepted, clear)
        null_blamed = null.length > norm(step) if model.has_criterion else 0
        blamed = [logic_or(part, logic_not(clear)) for part in (logic_not(null_blamed), null_blamed)]
        outcome = Outcome(accepted, verdict.ratio, null, *blamed)
        shorter = if_else(outcome.task_blamed, state["fraction"] / 2, state["fraction"])
        weights = zeros(state["weights"].shape[0])  # as many as rows: the number of levels is not known to a state
        weights[: len(model.levels)] = verdict.weights
        after = {
            "fraction": if_else(accepted, fmin(1, 2 * state["fraction"]), shorter),
            "weights": weights,
            "penalty": verdict.penalty,
        }
        if model.has_criterion:
            after |= self.secondary.adapt(model, state, proposed, outcome)
        figures = {
            "alpha": math.nan,
            "beta": null.beta,
            "V2": null.length**2 / 2,
            "predicted_decrease": model.predicted_decrease(-(model.full_J @ step)),
            "actual_decrease": model.here.V - point.V,
            **{f"scale_{k}": share for k, share in enumerate(shares)},
        }
        return Update(
            point=point,
            accepted=accepted,
            state=after,
            term=term,
            wanted=-unlimited,
            null_term=null.term,
            figures=figures,
            stationarity_residual=null.stationarity_residual,
            progress=verdict.progress,
        )

    def _tasks(self, model: LocalModel, here: Scaled) -> tuple[Scaled, Expression, list[Expression]]:
        """All levels, the highest first; the displacement they would make without limits; the share of each."""
        unlimited, shares, above = zeros(model.robot.n), list[Expression](), list[int]()
        for level in model.levels:
            rows = list(level)
            J, r = model.full_J[rows, :], model.here.residual[rows]
            missing = self.gain * r + J @ here.x
            keep = _unpressed(model, J.T @ missing) if len(model.levels) > 1 else None
            free = model.J[rows, :] if keep is None else J @ diag(keep)
            if above:
                basis = RowSpace(model.full_J[above, :] @ diag(keep)).unit_basis
                free = free - (free @ basis.T) @ basis
            damping = self.damping * sumsqr(r) / 2
            part = -(free.T @ damped_multipliers(free, damping, missing))
            here = here.with_task(J, free @ part)
            unlimited = unlimited + part
            shares.append(here.scale)
            above += rows
        return here, unlimited, shares

    def _null_move(self, model: LocalModel, state: State, here: Scaled) -> tuple[NullMove, Expression]:
        """What the criterion changes, and what it would without limits (n, 1)."""
        releases = self.releases()
        h = model.full_null_gradient if releases else model.null_gradient
        length = norm(h)
        known = self.secondary.barzilai_borwein(model, state)
        beta = fmin(if_else(known > 0, known, self.secondary.beta_max), ratio(state["null_cap"], length))
        wish = -beta * h
        move = (length > NOISE * norm(model.full_gradient)) * (here.towards(wish).x - here.x)
        moved = norm(move)
        null = NullMove(
            term=-move,
            length=moved,
            decrease=-dot(model.full_gradient, move),
            beta=beta,
            stationarity_residual=ratio(moved, beta) if releases else None,
        )
        return null, wish


def _unpressed(model: LocalModel, slope: Expression) -> Expression:
    """1 for joints that going down ``slope`` (n, 1) does not press against a limit, (n, 1): those of one level.

    The engine's working set, which a single level uses, is about all levels together.
    """
    low, high = model.box
    outwards = [
        logic_or(logic_and(high[j] < AT_LIMIT, slope[j] < 0), logic_and(low[j] > -AT_LIMIT, slope[j] > 0))
        for j in range(model.robot.n)
    ]
    return vertcat(*[logic_not(out) for out in outwards])
