"""The null-space step as a quadratic program, with the joint limits as its box (formulations/qp_secondary.md)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from jtik import register_secondary
from jtik.errors import ArgumentError
from jtik.qp import Program, Rows
from jtik.strategy import LocalModel, NullMove, State
from jtik.symbolic import Expression, diag, dot, fmin, if_else, norm, ratio, vertcat
from jtik_formulations.strategies.projected_gradient import NOISE, ProjectedGradient


@register_secondary("qp")
@dataclass(frozen=True, kw_only=True)
class QPSecondary(ProjectedGradient):
    """nu minimises 1/2 nu' W nu + beta grad H' nu where J nu = 0 and task step and nu together keep to the limits.

    Without limits and with W = I it is the projected gradient. With them, a joint that meets its limit does not stop
    the others: the program finds the best direction among those that are left, all at once.

    Attributes:
        weight: diagonal of W, one positive number or one a joint: a heavier joint moves less.

    beta follows the rule of `ProjectedGradient`, whose options are here too.

    Source: Siciliano, Sciavicco, Villani and Oriolo (2009), section 3.5.1 for the projection as a program; Kanoun,
    Lamiraux and Wieber (2011) for inequalities beside equalities.
    """

    weight: float | Sequence[float] = 1.0

    summary = "null-space step by a QP with the joint limits in it"
    source = "Kanoun, Lamiraux and Wieber 2011"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.rule != "merit":
            raise ArgumentError("rule", self.rule, "'merit': the other rules know nothing of limits")
        weight = np.asarray(self.weight, dtype=float)
        if weight.ndim > 1 or not (np.isfinite(weight).all() and (weight > 0).all()):
            raise ArgumentError("weight", self.weight, "a positive number, or one for each velocity entry")

    def solves_programs(self) -> bool:
        """Yes."""
        return True

    def propose(self, model: LocalModel, state: State, task_term: Expression) -> NullMove:
        """The program's answer, and how far H is from steady: |nu| / beta."""
        h, n = model.full_null_gradient, model.robot.n
        weight = np.broadcast_to(np.asarray(self.weight, dtype=float), n)
        length = norm(h)
        beta = fmin(self._barzilai_borwein(h, state), ratio(state["null_cap"], length))
        low, high = model.box
        fixed = Rows("task", model.full_rows.unit_basis, *[model.full_rows.dependent_bounds(s) for s in (-1, 1)])
        answer = model.solve(
            Program(
                P=diag(vertcat(*weight.tolist())),
                q=beta * model.full_gradient,
                lower=low + task_term,
                upper=high + task_term,
                rows=[fixed],
                name="null-space step",
            )
        )
        move = if_else(length > NOISE * norm(model.full_gradient), 1, 0) * answer.x
        moved = norm(move)
        return NullMove(
            term=-move,
            length=moved,
            decrease=-dot(model.full_gradient, move),
            beta=beta,
            unsteady=ratio(norm(weight * move), beta),
        )
