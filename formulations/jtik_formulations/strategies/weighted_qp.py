"""Task and criterion weighed against each other in one quadratic program (formulations/weighted_qp.md)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from jtik import register_strategy
from jtik.errors import ArgumentError, finite_array
from jtik.qp import QPSolution, QuadraticProgram
from jtik.strategy import Acceptance, LocalModel, Shape, State, Strategy, Update
from jtik.symbolic import (
    Expression,
    dot,
    fabs,
    fmax,
    fmin,
    identity,
    if_else,
    is_finite,
    logic_and,
    logic_or,
    mmax,
    norm,
    norm_inf,
    ratio,
    sumsqr,
    vertcat,
    zeros,
)
from jtik.types import Array

SUFFICIENT = 1e-4
"""Fraction of the predicted decrease an accepted step must bring (Armijo 1966)."""

ROUNDING = 1e-14
"""Relative error of an evaluated sum of V and H: a smaller change says nothing."""

HARDER, SOFTER = 8.0, 0.25
"""What a refusal and an acceptance make of the damping that the law adds by itself."""

FIRST_BRAKE = 1e-6
"""Least damping a refusal adds, relative to |J|^2: less would not shorten the step that was refused."""


PRESSED = 1e-6
"""Least multiplier of a limit that has a say, relative to 1 + |slope|: below it is the solver's."""


@register_strategy("weighted_qp")
@dataclass(frozen=True, kw_only=True)
class WeightedQP(Strategy):
    """dq minimises 1/2 |J dq + gain r|^2 + 1/2 mu |dq|^2 + weight (grad H' dq + 1/2 curvature |dq|^2) in the box.

    The program of mink, pink and most differential IK: one QP a step, limits in it, nothing strict about it. With a
    criterion it ends at a compromise, where the task is missed by ``weight`` times the price of the task in H.
    Prefer it where that is wanted, or to compare with those libraries; for a criterion that costs the task nothing
    take any other strategy. A posture cost p of theirs is ``weight=p**2`` beside `JointCentering`.

    mu = damping + lm_damping gain^2 |r|^2, and what refused steps have added. Without backtracking every step is
    taken, and with ``q_limit=math.inf`` that is theirs to rounding; a finite one is a velocity limit times dt.

    Attributes:
        gain: fraction of the error a step aims to remove, (0, 1].
        lm_damping: damping by the error: mu / (gain^2 |r|^2), [1 / rad^2].
        damping: constant part of mu, [unit of |J|^2]; keeps the program definite.
        weight: of H against V, [unit of V / unit of H].
        curvature: what the program takes for that of H, [unit of H / rad^2].
        q_limit: most that each rotational joint moves in a step [rad]; math.inf for no limit.
        backtracking: damp more until the weighted sum falls. Without it every step is taken.

    Source: Zakka, mink (2024); Caron et al., pink (2022); Sugihara (2011) for damping by the error.
    """

    gain: float = 1.0
    lm_damping: float = 0.05
    damping: float = 1e-9
    weight: float = 1e-5
    curvature: float = 1.0
    q_limit: float = 0.5
    backtracking: bool = True

    summary = "one QP: task, criterion and damping weighed against each other, limits as its box"
    source = "Zakka 2024 (mink); Caron et al. 2022 (pink)"
    is_soft: ClassVar[bool] = True

    def __post_init__(self) -> None:
        if not 0 < self.gain <= 1:
            raise ArgumentError("gain", self.gain, "a number in (0, 1]")
        for name in ("damping", "weight", "curvature"):
            finite_array(name, getattr(self, name), ())
            if not 0 < getattr(self, name) < math.inf:
                raise ArgumentError(name, getattr(self, name), "a positive, finite number")
        if not 0 <= self.lm_damping < math.inf:
            raise ArgumentError("lm_damping", self.lm_damping, "a finite number from 0")
        if not self.q_limit > 0:
            raise ArgumentError("q_limit", self.q_limit, "a positive angle [rad], math.inf for none")

    def acceptance(self) -> Acceptance:
        """``"merit"``: V, or with a criterion gain V + weight H, falls; ``"always"`` without backtracking."""
        return "merit" if self.backtracking else "always"

    def evaluates_candidate(self, has_criterion: bool) -> bool:
        """With backtracking, or to see what becomes of the criterion."""
        return self.backtracking or has_criterion

    def uses_qp(self, has_criterion: bool) -> bool:
        """Always one."""
        return True

    def supports_clearances(self) -> bool:
        """Its programs have the rows."""
        return True

    def initial_state(self, shape: Shape) -> Mapping[str, Array]:
        """The damping that refusals have added."""
        return {"brake": np.zeros(1)} if self.backtracking else {}

    def update(self, model: LocalModel, state: State) -> Update:
        """The program, and whether its answer is taken."""
        J, r, n = model.full_J, model.here.residual, model.robot.n
        mu = self.damping + self.lm_damping * self.gain**2 * sumsqr(r)
        slope = self.gain * (J.T @ r)
        if model.has_criterion:
            mu = mu + self.weight * self.curvature
            slope = slope + self.weight * model.full_gradient
        brake: Expression = state["brake"] if self.backtracking else 0
        P = J.T @ J + (mu + brake) * identity(n)
        low, high = capped(model, self.q_limit)
        rows = [model.recovery.within(low, high).rows] if model.clearance else []
        answer = model.solve(QuadraticProgram(P=P, q=slope, lower=low, upper=high, rows=rows, name="step"))
        dq = answer.x
        point = model.moved(-dq)
        predicted = -dot(slope, dq) - self.gain * sumsqr(J @ dq) / 2
        actual = self.gain * (model.here.V - point.V)
        progress = None
        noise: Expression = 0
        if model.has_criterion:
            actual = actual + self.weight * (model.here.H - point.H)
            size = self.gain * model.here.V + self.weight * (fabs(model.here.H) + fabs(point.H))
            noise, progress = ROUNDING * size, ratio(actual, size)
        accepted: Expression = 1
        after: dict[str, Expression] = {}
        if self.backtracking:
            accepted = logic_and(predicted > 0, actual >= SUFFICIENT * predicted - noise)
        if model.clearance:
            accepted = logic_or(accepted, model.recovery.takes(-dq, point.length))
            accepted = logic_and(accepted, model.clearance.keeps(-dq))
        if self.backtracking:
            harder = fmax(HARDER * brake, fmax(mu, FIRST_BRAKE * model.full_rows.squared_length))
            after["brake"] = if_else(accepted, SOFTER * brake, harder)
        watched = point.V + point.H if self.evaluates_candidate(model.has_criterion) else dq
        figures = {
            "alpha": math.nan,
            "beta": math.nan,
            "V2": 0,
            "predicted_decrease": predicted,
            "actual_decrease": model.here.V - point.V,
            "mu": mu + brake,
        }
        return Update(
            point=point,
            accepted=logic_and(accepted, is_finite(watched)),
            state=after,
            term=-dq,
            wanted=-dq,
            null_term=zeros(n),
            figures=figures,
            progress=progress,
            relaxed={("task", "of its residual"): if_else(_hindered(answer), norm(model.here.residual + J @ dq), 0)},
        )


def _hindered(answer: QPSolution) -> Expression:
    """Whether a limit or a row has a say in the step."""
    program = answer.program
    forces = [fabs(answer.box_multipliers[j]) for j in range(program.size)]
    for group in program.rows:
        multipliers = answer.multipliers(group.name)
        forces += [fabs(multipliers[i]) * norm(group.matrix[i, :]) for i in range(group.count)]
    return mmax(vertcat(*forces)) > PRESSED * (1 + norm_inf(program.q))


def capped(model: LocalModel, q_limit: float) -> tuple[Expression, Expression]:
    """The joint limits' box, (n, 1) each, with no rotation longer than ``q_limit`` [rad]."""
    low, high = model.box
    if not math.isfinite(q_limit):
        return low, high
    cap = [q_limit if turns else math.inf for turns in model.rotational]
    return vertcat(*[fmax(low[j], -c) for j, c in enumerate(cap)]), vertcat(
        *[fmin(high[j], c) for j, c in enumerate(cap)]
    )
