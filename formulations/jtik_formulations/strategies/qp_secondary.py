"""The null-space step as a quadratic program, with the joint limits as its box (formulations/qp_secondary.md)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from jtik import register_secondary
from jtik.arguments import array_of
from jtik.constraints.limits import AT_LIMIT
from jtik.errors import ArgumentError
from jtik.qp import QuadraticProgram, Rows
from jtik.strategy import LocalModel, NullSpaceDisplacement, Outcome, State
from jtik.symbolic import (
    Expression,
    diag,
    fmax,
    fmin,
    horzcat,
    if_else,
    logic_and,
    logic_not,
    logic_or,
    norm,
    ratio,
    vertcat,
)
from jtik.symbolic.factorization import RowSpace
from jtik.types import Array
from jtik_formulations.bibliography import KANOUN_2011
from jtik_formulations.strategies._parts.significance import in_null_space, significant
from jtik_formulations.strategies._parts.task_within_clearances import within_clearances
from jtik_formulations.strategies.projected_gradient import ProjectedGradient


@register_secondary("qp")
@dataclass(frozen=True, kw_only=True)
class QPSecondary(ProjectedGradient):
    """nu minimises 1/2 nu' W nu + beta grad H' nu where J nu = 0 and task step and nu together are within the limits.

    Without limits and with W = I it is the projected gradient. With limits, a joint that reaches its limit does not
    stop the others: the quadratic program finds the best of the directions that the limits allow. beta follows
    the rule "merit" of `ProjectedGradient`.

    Attributes:
        weight: diagonal of W, the metric of the null-space step: one positive number, or one for each velocity entry.
            A heavier joint moves less for the criterion. It does not affect the task step, and nothing without a
            criterion: ``InverseKinematics(weights=)`` is for both.
        rule: "merit".
        step_limit: longest null-space step [rad].
        beta_max: first gain; the unit of q^2 over that of H.
        floor: not used.

    Source: Siciliano, Sciavicco, Villani and Oriolo (2009), section 3.5.1 for the projection as a quadratic program;
    Kanoun, Lamiraux and Wieber (2011) for inequalities beside equalities.
    """

    weight: float | Sequence[float] = 1.0

    summary = "null-space step by a QP with the joint limits in it"
    source = "Kanoun, Lamiraux and Wieber 2011"
    bibtex = KANOUN_2011

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.rule != "merit":
            raise ArgumentError("rule", self.rule, "'merit': the other rules ignore limits")
        accepted = "a positive number, or one for each velocity entry"
        if np.ndim(array_of("weight", self.weight, [(), (None,)], accepted, lambda x: (x > 0) & np.isfinite(x))) == 0:
            object.__setattr__(self, "weight", float(self.weight))  # type: ignore[arg-type]

    def uses_qp(self) -> bool:
        """Always."""
        return True

    def supports_clearances(self) -> bool:
        """Always."""
        return True

    def propose(self, model: LocalModel, state: State, task_dq: Expression) -> NullSpaceDisplacement:
        """The solution of the quadratic program, and the stationarity residual of H, |W nu| / beta.

        With clearances also the task displacement that they allow; without a criterion that is all.
        """
        if not model.clearance:
            return self.beside(model, state, task_dq)
        clear = within_clearances(model, task_dq, self._weights(model))
        null = NullSpaceDisplacement.none(model.robot.n)
        if model.has_criterion:
            null = self.beside(model, state, clear.dq)
        return replace(
            null,
            task_dq=clear.dq,
            within_limits=True,
            figures={"task_share": clear.share},
            relaxed={("task step", "share"): clear.relaxed},
        )

    def adapt(self, model: LocalModel, state: State, null_space: NullSpaceDisplacement, outcome: Outcome) -> State:
        """The state of the gain after the outcome is known."""
        return self.gain.adapt(model, state, model.null_gradient, null_space, outcome)

    def beside(self, model: LocalModel, state: State, task_dq: Expression) -> NullSpaceDisplacement:
        """nu beside a task displacement that is within limits and clearances; the sum of both is, too."""
        h = _reduced_gradient(model)
        length, (low, high), weight = norm(h), model.box, vertcat(*self._weights(model).tolist())
        # of all joints: a quadratic program finds the active limits by itself
        beta = fmin(self.gain.gain(model, state, model.null_gradient), ratio(state["null_cap"], length))
        beta = model.null_space_share * beta
        is_significant = if_else(significant(length, norm(model.gradient)), 1, 0)
        rows = [Rows.in_null_space("task", model.row_space)]
        if model.clearance:  # the task displacement is within them, to the accuracy of the solver
            clear = model.restoration.rows
            rows.append(Rows(clear.name, clear.matrix, fmin(clear.lower - clear.product(task_dq), 0), clear.upper))
        solution = model.solve(
            QuadraticProgram(
                P=diag(weight),
                q=is_significant * beta * model.null_gradient,  # the rest of the gradient changes only the multipliers
                lower=low - task_dq,
                upper=high - task_dq,
                rows=rows,
                name="null-space step",
                known_convex=True,
            )
        )
        dq = is_significant * solution.x
        residual = ratio(model.joint_gradient_norm(weight * dq), beta)
        # a step that is short because it ends at a limit says nothing about the gradient before the joint is there
        residual = if_else(_arrives(model, task_dq + dq), fmax(residual, length), residual)
        # what is not in the null space is the solver's noise
        dq = in_null_space(model.row_space.unit_basis, dq, task_dq) * dq
        return NullSpaceDisplacement(dq=dq, beta=beta, stationarity_residual=residual, within_limits=True)

    def _weights(self, model: LocalModel) -> Array:
        """The diagonal of W (n,). Raises ArgumentError where there are not as many weights as velocity entries."""
        weight, n = np.asarray(self.weight, dtype=float), model.robot.n
        if weight.shape not in ((), (n,)):
            raise ArgumentError("weight", self.weight, f"a positive number, or {n}, one for each velocity entry")
        return np.broadcast_to(weight, n)


def _arrives(model: LocalModel, dq: Expression) -> Expression:
    """1 where a displacement ends at a limit, to `AT_LIMIT`, at which the joint is not yet; else 0."""
    low, high = model.box
    arrives: Expression = 0
    for _, j in model.bounded:
        below = logic_and(low[j] < -AT_LIMIT, dq[j] - low[j] < AT_LIMIT)
        above = logic_and(high[j] > AT_LIMIT, high[j] - dq[j] < AT_LIMIT)
        arrives = logic_or(arrives, logic_or(below, above))
    return arrives


def _reduced_gradient(model: LocalModel) -> Expression:
    """(I - J+ J) dH/dv of the joints that -h does not push outward at a limit, (n, 1): for the gain.

    An estimate of what the quadratic program will find. At the optimum it vanishes, where that of all joints need not.
    """
    h = model.null_gradient
    if not model.bounded:
        return h
    low, high = model.box
    free: list[Expression] = [1] * model.robot.n
    for _, j in model.bounded:
        outward = logic_or(logic_and(high[j] < AT_LIMIT, h[j] < 0), logic_and(low[j] > -AT_LIMIT, h[j] > 0))
        free[j] = logic_not(outward)
    J = horzcat(*[model.J[:, j] * keep for j, keep in enumerate(free)])
    return RowSpace(J).split(vertcat(*free) * model.gradient).null
