"""Task and criterion weighted against each other in one quadratic program (formulations/weighted_qp.md)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from jtik import register_strategy
from jtik.qp import QPSolution, QuadraticProgram
from jtik.strategy import (
    Acceptance,
    AdaptiveDamping,
    LocalModel,
    Programmed,
    Proposal,
    State,
    WeightedMerit,
    check_gain,
    check_non_negative,
    check_positive,
    check_step_limit,
    limited_box,
)
from jtik.symbolic import Expression, dot, fabs, fmax, gram, identity, if_else, mmax, norm, norm_inf, sumsqr, vertcat

DAMPING = AdaptiveDamping(increase=8.0, decrease=0.25)
"""Damping that refusals add."""

SMALLEST_DAMPING = 1e-6
"""Smallest damping that a refusal adds, relative to |J|^2: less would not shorten the step that was refused."""

ACTIVE = 1e-6
"""Smallest multiplier of an active limit, relative to 1 + |gradient|: below it is the solver's tolerance."""


@register_strategy("weighted_qp")
@dataclass(frozen=True, kw_only=True)
class WeightedQP(Programmed):
    """dq minimises 1/2 |J dq + gain r|^2 + 1/2 mu |dq|^2 + weight (grad H' dq + 1/2 curvature |dq|^2) in the box.

    The quadratic program of mink, pink and most differential IK: one QP a step, with the limits in it. It is soft: with
    a criterion it ends at a compromise, where the task is missed by ``weight`` times the multiplier of the task in H.
    Prefer it where that is wanted, or to compare with those libraries; where the criterion must not
    affect the task, use any other strategy. A posture cost p of theirs is ``weight=p**2`` beside `JointCentering`.

    mu = damping + lm_damping gain^2 |r|^2, and the damping added by refused steps. Without backtracking every step is
    taken; with ``q_limit=math.inf`` as well it equals theirs to rounding. A finite limit is a velocity limit times dt.

    Attributes:
        gain: fraction of the error a step aims to remove, (0, 1].
        lm_damping: damping by the error: mu / (gain^2 |r|^2), [1 / rad^2].
        damping: constant part of mu, [unit of |J|^2]; keeps the quadratic program strictly convex.
        weight: of H against V, [unit of V / unit of H].
        curvature: curvature of H that the quadratic program assumes, [unit of H / rad^2].
        q_limit: largest motion of each rotational joint in a step [rad]; math.inf for no limit.
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

    summary = "one QP: task, criterion and damping weighted against each other, limits as its box"
    source = "Zakka 2024 (mink); Caron et al. 2022 (pink)"
    is_soft: ClassVar[bool] = True

    def __post_init__(self) -> None:
        check_gain(self.gain)
        for name in ("damping", "weight", "curvature"):
            check_positive(name, getattr(self, name))
        check_non_negative("lm_damping", self.lm_damping)
        check_step_limit("q_limit", self.q_limit)

    def propose(self, model: LocalModel, state: State) -> Proposal:
        """The solution of the quadratic program."""
        J, r, n = model.J, model.here.residual, model.robot.n
        mu = self.damping + self.lm_damping * self.gain**2 * sumsqr(r)
        gradient = self.gain * (J.T @ r)
        if model.has_criterion:
            mu = mu + self.weight * self.curvature
            gradient = gradient + self.weight * model.gradient
            if model.timed:  # the part in the null space sets the speed there
                gradient = gradient - self.weight * (1 - model.null_space_share) * model.null_gradient_free
        added: Expression = state[DAMPING.name] if self.backtracking else 0
        P = gram(J) + (mu + added) * identity(n)
        if model.timed:  # where there is a criterion its motion in the null space is not damped
            damped = gram(model.row_space_free.unit_basis) if model.has_criterion else identity(n)
            P = P + model.curvature * damped
        low, high = limited_box(model, self.q_limit)
        rows = [model.restoration.within(low, high).rows] if model.clearance else []
        solution = model.solve(QuadraticProgram(P=P, q=gradient, lower=low, upper=high, rows=rows, name="step"))
        dq = solution.x
        missed = if_else(_limits_active(solution), norm(r + J @ dq), 0)
        return Proposal(
            dq=dq,
            predicted_decrease=-dot(gradient, dq) - self.gain * sumsqr(J @ dq) / 2,
            smallest_damping=fmax(mu, SMALLEST_DAMPING * model.row_space.squared_length),
            figures={"beta": math.nan, "mu": mu + added},
            relaxed={("task", "of its residual"): missed},
        )

    def merit(self) -> WeightedMerit:
        """gain V + weight H."""
        return WeightedMerit(self.gain, self.weight)

    def acceptance(self) -> Acceptance:
        """By merit, or always without backtracking."""
        return "merit" if self.backtracking else "always"

    def shortening(self) -> AdaptiveDamping | None:
        """Damping, with backtracking."""
        return DAMPING if self.backtracking else None

    def supports_clearances(self) -> bool:
        """Always."""
        return True


def _limits_active(solution: QPSolution) -> Expression:
    """1 where a limit or a row is active in the step."""
    qp = solution.qp
    multipliers = [fabs(solution.box_multipliers[j]) for j in range(qp.size)]
    for group in qp.rows:
        of_rows = solution.multipliers(group.name)
        multipliers += [fabs(of_rows[i]) * norm(group.matrix[i, :]) for i in range(group.count)]
    return mmax(vertcat(*multipliers)) > ACTIVE * (1 + norm_inf(qp.q))
