"""Task and criterion weighted against each other in one quadratic program (formulations/weighted_qp.md)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from jtik import register_strategy
from jtik.qp import QPSolution, QuadraticProgram
from jtik.strategy import (
    Acceptance,
    AdaptiveDamping,
    LocalModel,
    NonNegative,
    Outcome,
    Positive,
    Programmed,
    Proposal,
    Shape,
    Share,
    State,
    StepLimit,
    WeightedMerit,
    limited_box,
)
from jtik.symbolic import (
    Expression,
    dot,
    fabs,
    fmax,
    fmin,
    gram,
    identity,
    if_else,
    mmax,
    norm,
    norm_inf,
    sumsqr,
    vertcat,
)
from jtik.types import Array
from jtik_formulations.bibliography import MINK_2024, PINK_2022
from jtik_formulations.strategies._parts.secant_hessian import SecantHessian

DAMPING = AdaptiveDamping(increase=8.0, decrease=0.25)
"""Damping that refusals add."""

SMALLEST_DAMPING = 1e-6
"""Smallest damping that a refusal adds, relative to |J|^2: less would not shorten the step that was refused."""

ACTIVE = 1e-6
"""Smallest multiplier of an active limit, relative to 1 + |gradient|: below it is the solver's tolerance."""

CORRECTIONS = 2
"""Second-order corrections of a step: with one, solves with the default weight take 1.7 times as many steps."""

SHORT = 0.5
"""Longest correction, relative to the step that it corrects; a longer one is omitted."""


@register_strategy("weighted_qp")
@dataclass(frozen=True, kw_only=True)
class WeightedQP(Programmed):
    """dq minimises 1/2 |J dq + gain r|^2 + 1/2 mu |dq|^2 + weight (grad H' dq + 1/2 dq' B dq) in the box.

    The quadratic program of mink, pink and most differential IK: one QP a step, with the limits in it. It is soft: with
    a criterion it minimises gain V + weight H, and a solve ends at a stationary point of that sum, where the task is
    missed by ``weight`` times the multiplier of the task in H. That error is within the tolerance, and the solve
    converged, or its status is `jtik.Status.COMPROMISE`. Prefer it where that is wanted, or to compare with those
    libraries; where the criterion must not affect the task, use any other strategy. A posture cost p of theirs is
    ``weight=p**2`` beside `JointCentering`.

    mu = damping + lm_damping gain^2 |r|^2, and the damping added by refused steps. B begins as ``curvature`` times the
    identity and learns from the steps what the second derivatives are; a step is corrected for the curvature of the
    task. Without backtracking every step is taken, and B remains as it is, as in a step with a time; with
    ``q_limit=math.inf`` as well the step then equals theirs to rounding. A finite limit is a velocity limit times dt.

    Attributes:
        gain: fraction of the error a step aims to remove, (0, 1].
        lm_damping: damping by the error: mu / (gain^2 |r|^2), [1 / rad^2]; half the ``damping`` of `Damped`, mu / V.
        damping: constant part of mu, [unit of |J|^2]; keeps the quadratic program strictly convex.
        weight: of H against V, [unit of V / unit of H].
        curvature: curvature of H that the first step assumes, [unit of H / rad^2].
        q_limit: largest motion of each rotational joint in a step [rad]; math.inf for no limit.
        backtracking: damp more until the weighted sum falls. Without it every step is taken.

    Source: Zakka, mink (2024); Caron et al., pink (2022); Sugihara (2011) for damping by the error; Powell (1978) for
    B; Maratos (1978), Fletcher (1982) for the correction.
    """

    gain: Share = 1.0
    lm_damping: NonNegative = 0.05
    damping: Positive = 1e-9
    weight: Positive = 1e-5
    curvature: Positive = 1.0
    q_limit: StepLimit = 0.5
    backtracking: bool = True

    summary = "one QP: task, criterion and damping weighted against each other, limits as its box"
    source = "Zakka 2024 (mink); Caron et al. 2022 (pink)"
    bibtex = "\n".join((MINK_2024, PINK_2022))
    is_soft: ClassVar[bool] = True

    def own_state(self, shape: Shape) -> Mapping[str, Array]:
        """What is known of the second derivatives, where the step uses them."""
        return self._secant.initial_state(shape) if self._learns(shape) else {}

    def propose(self, model: LocalModel, state: State) -> Proposal:
        """The solution of the quadratic program, corrected for the curvature of the task."""
        J, r, n = model.J, model.here.residual, model.robot.n
        learns = self._learns(model)
        mu = self.damping + self.lm_damping * self.gain**2 * sumsqr(r)
        added: Expression = state[DAMPING.name] if self.backtracking else 0
        gradient = self.gain * (J.T @ r)
        known: State = {}
        P, smallest = gram(J), mu
        if model.has_criterion:
            gradient = gradient + self.weight * model.gradient
            if learns:
                B = self._secant.at(model, state, self.gain / self.weight * r)
                P, known = P + self.weight * B, self._secant.known(model, B)
                smallest = mu + self.weight * self.curvature
            else:
                mu = smallest = mu + self.weight * self.curvature
            if model.timed:  # the part in the null space sets the speed there
                gradient = gradient - self.weight * (1 - model.null_space_share) * model.null_gradient_free
        P = P + (mu + added) * identity(n)
        if model.timed:  # where there is a criterion its motion in the null space is not damped
            damped = gram(model.row_space_free.unit_basis) if model.has_criterion else identity(n)
            P = P + model.curvature * damped
        box = limited_box(model, self.q_limit)
        rows = [model.restoration.within(*box).rows] if model.clearance else []
        linear = gradient + P @ model.weak_motion if model.accelerated else gradient
        solution = model.solve(QuadraticProgram(P, linear, *box, rows, "step", known_convex=True))
        dq = solution.x
        return Proposal(
            dq=_corrected(model, dq, box) if learns else dq,
            predicted_decrease=-dot(gradient, dq) - self.gain * sumsqr(J @ dq) / 2,
            smallest_damping=fmax(smallest, SMALLEST_DAMPING * model.row_space.squared_length),
            state=known,
            figures={"beta": math.nan, "mu": mu + added},
            compromise_residual=self.merit().compromise_residual(model, _taken_by_rows(solution)),
            relaxed={("task", "of its residual"): if_else(_limits_active(solution), norm(r + J @ dq), 0)},
        )

    def adapt(self, model: LocalModel, state: State, proposal: Proposal, outcome: Outcome) -> State:
        """What this step shows of the second derivatives."""
        after = self._secant.after(model, proposal.dq, outcome.accepted) if self._learns(model) else {}
        return {**proposal.state, **after}

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

    @property
    def _secant(self) -> SecantHessian:
        return SecantHessian(self.curvature)

    def _learns(self, of: LocalModel | Shape) -> bool:
        """Whether the step uses second derivatives: one with a time remains as quiet as it is without them."""
        return of.has_criterion and self.backtracking and not of.timed


def _corrected(model: LocalModel, dq: Expression, box: tuple[Expression, Expression]) -> Expression:
    """The step (n, 1) with its second-order corrections, -J+ times the error that the linear model of r leaves.

    Without them a step along a valley of V that is narrow beside H raises V to second order by more than it lowers H
    (Maratos effect).
    """
    wanted, corrected = model.here.residual + model.J @ dq, dq
    for _ in range(CORRECTIONS):
        error = model.candidate(corrected).residual - wanted
        corrected = fmin(fmax(corrected - model.row_space_free.least_squares(error).vector, box[0]), box[1])
    return if_else(norm(corrected - dq) <= SHORT * norm(dq), corrected, dq)


def _taken_by_rows(solution: QPSolution) -> Expression:
    """The part of the gradient (n, 1) that the rows of the quadratic program take, by their multipliers."""
    return sum(group.combination(solution.multipliers(group.name)) for group in solution.qp.rows)


def _limits_active(solution: QPSolution) -> Expression:
    """1 where a limit or a row is active in the step."""
    qp = solution.qp
    multipliers = [fabs(solution.box_multipliers[j]) for j in range(qp.size)]
    for group in qp.rows:
        multipliers.append(group.sizes(solution.multipliers(group.name)))
    return mmax(vertcat(*multipliers)) > ACTIVE * (1 + norm_inf(qp.q))
