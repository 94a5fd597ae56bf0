"""Saturation in the null space by quadratic programs, which a QP solver solves (formulations/sns.md)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import inf

from jtik import register_strategy
from jtik.qp import QPSolution, QuadraticProgram, Rows
from jtik.strategy import LocalModel
from jtik.symbolic import Expression, dot, fmax, fmin, identity, if_else, logic_and, mmax, norm, sumsqr, vertcat, zeros
from jtik.symbolic.factorization import RowSpace, squared_length
from jtik_formulations.bibliography import FLACCO_2015
from jtik_formulations.strategies._parts.saturation import DEPENDENT, rotated_rows
from jtik_formulations.strategies._parts.task_scaling import TaskScaling

PENALTY = 1e4
"""Weight of x along the task in units of |x|^2 / 2: larger than every multiplier in our tests."""

INACTIVE = 1e-7
"""Distance from a bound [rad] or [m] above which the bound is surely not active in a solver's solution."""


@dataclass(frozen=True)
class QPScaling:
    """A displacement x in a box by one QP for each task: the largest share of the task first, then the shortest x.

    Attributes:
        solve: solves quadratic programs.
        lower: lower bounds of x (n, 1), at most 0.
        upper: upper bounds of x (n, 1), at least 0.
        x: the displacement (n, 1).
        rows: Jacobians of the tasks so far (k, n).
        scale: s of the last task.
    """

    solve: Callable[[QuadraticProgram], QPSolution]
    lower: Expression
    upper: Expression
    x: Expression
    rows: Expression
    scale: Expression

    @classmethod
    def initial(
        cls, solve: Callable[[QuadraticProgram], QPSolution], lower: Expression, upper: Expression
    ) -> QPScaling:
        """No displacement and no task."""
        n = lower.shape[0]
        return cls(solve, lower, upper, zeros(n), zeros(0, n), 1)

    def with_task(self, J: Expression, change: Expression) -> QPScaling:
        """J x changes by s ``change`` (m, 1) with the largest s up to 1; of all such x the shortest."""
        along, across = rotated_rows(J, change)
        row_length = norm(along)
        fixed = vertcat(self.rows, across)
        space = RowSpace(fixed, squared_scale=squared_length(J))
        rest = space.split(along / row_length).null
        length = norm(rest)
        direction = if_else(length > DEPENDENT, 1, 0) * rest / length
        total = norm(change) / (row_length * length)
        free = self.x + total * direction  # the solution without a box
        inside = logic_and(self._inside(self.x), self._inside(free))
        away = self.x - PENALTY * fmin(total, 1) * direction
        start = if_else(inside, free, self.x)
        task = Rows("task", direction.T, zeros(1) - inf, if_else(inside, 0, total))
        x = self._solved(space, start, if_else(inside, 0, 1) * away, [task], "scaled task")
        share = fmin(fmax(dot(direction, x - self.x) / total, 0), 1)
        scale = if_else(sumsqr(change) > 0, share, 1)
        return replace(self, x=x, rows=vertcat(self.rows, J), scale=scale)

    def towards(self, wanted: Expression) -> QPScaling:
        """Of all x with the same J x, the closest to ``wanted`` (n, 1), a null-space displacement of the tasks."""
        # without active bounds x is orthogonal to the null space of the tasks
        q = if_else(self._inside(self.x), 0, 1) * self.x - wanted
        return replace(self, x=self._solved(RowSpace(self.rows), self.x, q, [], "criterion"))

    def _inside(self, x: Expression) -> Expression:
        """1 where no bound is active at x."""
        return logic_and(mmax(self.lower - x) < -INACTIVE, mmax(x - self.upper) < -INACTIVE)

    def _solved(self, kept: RowSpace, start: Expression, q: Expression, rows: list[Rows], name: str) -> Expression:
        """The x that minimises 1/2 |x - start|^2 + q' (x - start) within box and rows, and keeps the kept rows."""
        n = q.shape[0]
        if kept.unit_basis.shape[0]:
            rows = [Rows.in_null_space("kept", kept), *rows]
        qp = QuadraticProgram(
            identity(n), q, self.lower - start, self.upper - start, rows, name=name, known_convex=True
        )
        return fmin(fmax(start + self.solve(qp).x, self.lower), self.upper)


@register_strategy("sns_qp")
@dataclass(frozen=True, kw_only=True)
class SNSQP(TaskScaling):
    """The steps of ``"sns"`` by quadratic programs: one for each level of priority, and one for the criterion.

    For comparison with ``SNS``, and for robots with so many joints that a solver is faster. Options and guarantees are
    those of ``SNS``.

    Attributes:
        gain: share of the error to remove in a step, in (0, 1].
        damping: damping of the task near singular poses, mu / V [1 / rad^2]; 0 for none.
        q_limit: largest motion of each rotational joint in a step [rad]; math.inf for no limit.
        backtracking: halve the step until V falls, or the penalty function of several levels.
        secondary: rule of beta.

    Source: Flacco, De Luca and Khatib (2015).
    """

    summary = "saturation in the null space by quadratic programs, for comparison with sns"
    source = "Flacco, De Luca and Khatib 2015"
    bibtex = FLACCO_2015

    def uses_qp(self, has_criterion: bool) -> bool:
        """One for each level, and one for a criterion."""
        return True

    def initial(self, model: LocalModel, lower: Expression, upper: Expression) -> QPScaling:
        """By quadratic programs."""
        return QPScaling.initial(model.solve, lower, upper)
