"""The problem that a strategy solves: robot, tasks, criteria and limits as CasADi functions."""

from __future__ import annotations

import copy
from collections.abc import Callable, Sequence
from typing import Any, TypeVar

from jtik._step.measurement import Measurement
from jtik.constraints.clearance import Clearance
from jtik.criterion import CriterionTerms
from jtik.robot import UNWEIGHTED, Robot, WeightedCoordinates
from jtik.strategy.curvature import lagrangian_hessian
from jtik.symbolic import (
    Expression,
    Function,
    dot,
    function,
    gradient,
    horzcat,
    jacobian,
    norm,
    substitute,
    sum1,
    symbol,
    vertcat,
    zeros,
)
from jtik.task import TaskStack
from jtik.types import Array

T = TypeVar("T")


class SymbolicProblem:
    """Robot, tasks, criteria and limits as CasADi functions of (q, target, parameters).

    Attributes:
        robot: the robot.
        tasks: its tasks.
        terms: its criteria.
        bounded: (q index, v index) of the joints that have a limit.
        position_limits: lower and upper position limits (nq,); None without any.
        locked: velocity entries of the joints that their limits lock; a step is made as if they were not there.
        clearances: its clearances.
        coordinates: of the displacements of a step, from the joint weights; the functions below are without them.
        linear: for each task row, whether it is a length [m] rather than an angle [rad].
        levels: the rows of each level of priority, the highest first.
        factor: L with Kp = L L', (m, m).
        error: (q, target) -> e, (m, 1).
        residual: (q, target) -> r = L' e, (m, 1).
        unshifted: (q, target) -> r for the target with zeros where its numbers only shift r; None where none do.
        error_jacobian: (q, target) -> derivative of e with respect to the velocity, (m, n).
        residual_jacobian: (q, target) -> derivative of r with respect to the velocity, (m, n).
        criterion: (q, parameters) -> H.
        values: (q, parameters) -> the weighted value of each criterion.
        least_squares: the criteria that are in residual form, for their Gauss-Newton Hessian; None without any.
        measured: what its clearances measure; without any there is no such attribute.
    """

    def __init__(
        self,
        robot: Robot,
        tasks: TaskStack,
        terms: CriterionTerms,
        bounded: tuple[tuple[int, int], ...],
        clearances: tuple[Clearance, ...] = (),
        coordinates: WeightedCoordinates = UNWEIGHTED,
    ) -> None:
        self.robot, self.tasks, self.terms, self.bounded = robot, tasks, terms, bounded
        self._built: dict[tuple[Any, ...], Any] = {}
        self.coordinates = coordinates
        self.position_limits: tuple[Array, Array] | None = None
        self.locked: tuple[int, ...] = ()
        q, target, parameters = self.symbols()
        kinematics = robot.at(q)
        rows = tasks.rows(kinematics, target)
        values = terms.values(kinematics, parameters)
        self.linear, self.levels = rows.linear, rows.levels
        self.factor = tasks.weight_factor()
        self.error = function("error", [q, target], [rows.error])
        self.residual = function("residual", [q, target], [self.factor.T @ rows.error])
        self.unshifted = self._unshifted(q, target)
        self.error_jacobian = function("error_jacobian", [q, target], [rows.jacobian])
        self.residual_jacobian = function("residual_jacobian", [q, target], [self.factor.T @ rows.jacobian])
        self._near_jacobian = [q, target], self.factor.T @ rows.near_jacobian
        self.least_squares = terms.least_squares()
        self.clearances = clearances
        if clearances:
            self.measured = Measurement.of(clearances, terms, kinematics, parameters)
        self.values = function("criteria", [q, parameters], [vertcat(*values)])
        self.criterion = function("criterion", [q, parameters], [self._total(q, parameters)], cse=False)

    def _total(self, q: Expression, parameters: Expression) -> Expression:
        """H, the sum of the values of the criteria."""
        values = self.values(q, parameters)
        return sum((values[i] for i in range(values.shape[0])), zeros(1))

    def _unshifted(self, q: Expression, target: Expression) -> Function | None:
        """The residual without the numbers of the target whose derivative is constant, such as those of a position."""
        residual = self.residual(q, target)
        rates = jacobian(residual, target)
        shifts = [rates[:, i].nnz() > 0 and rates[:, i].is_constant() for i in range(target.shape[0])]
        if not any(shifts):
            return None
        kept = vertcat(*[0 if shift else target[i] for i, shift in enumerate(shifts)])
        return function("unshifted", [q, target], [substitute(residual, target, kept)])

    def symbols(self) -> tuple[Expression, Expression, Expression]:
        """Fresh symbols for q, target and parameters."""
        return (
            symbol("q", self.robot.nq),
            symbol("target", self.tasks.target_size),
            self.terms.parameters.symbols(),
        )

    @property
    def scalar(self) -> tuple[tuple[int, int], ...]:
        """(q index, v index) of all joints that can have a limit: revolute and prismatic ones."""
        pairs = zip(self.robot.scalar_q.tolist(), self.robot.scalar_v.tolist(), strict=True)
        return tuple(pairs)

    def once(self, name: str, build: Callable[[], T], *, keep: Callable[[T], bool] | None = None) -> T:
        """What ``build`` returns, which is built once for this problem and its copies.

        Args:
            name: its name, unique among what is built of problems.
            build: builds something that has no memory, such as a function.
            keep: whether the copies may share it; None for always.
        """
        key = (name, self.bounded)
        if key in self._built:
            found: T = self._built[key]
            return found
        built = build()
        if keep is None or keep(built):
            self._built[key] = built
        return built

    def copied(self, terms: CriterionTerms) -> SymbolicProblem:
        """The same problem with terms, equal to its own, whose live parameters are others."""
        problem = copy.copy(self)
        problem.terms = terms
        return problem

    def with_limits(self) -> SymbolicProblem:
        """The same problem in which every joint of `scalar` has a limit."""
        problem = copy.copy(self)
        problem.bounded = self.scalar
        return problem

    def movable(self, J: Expression) -> Expression:
        """A derivative by dq (m, n) in the coordinates of the step, with zeros for the joints that limits lock."""
        J = self.coordinates.jacobian(J)
        if not self.locked:
            return J
        return horzcat(*[zeros(J.shape[0]) if j in self.locked else J[:, j] for j in range(J.shape[1])])

    @property
    def m(self) -> int:
        """Number of task rows."""
        return len(self.linear)

    @property
    def has_criterion(self) -> bool:
        """Whether there is a criterion."""
        return len(self.terms.named) > 0

    def near_jacobian(self) -> Function:
        """(q, target) -> a cheaper matrix (m, n) that approaches the residual's Jacobian near the target."""
        arguments, J = self._near_jacobian
        return self.once("near_jacobian", lambda: function("near_jacobian", arguments, [J]))

    def gradient(self, expression: Expression, q: Expression) -> Expression:
        """Derivative of a scalar with respect to the velocity, T(q)' (d/dq)', as a column, in reverse mode."""
        return self.robot.tangent(q).T @ gradient(expression, q)

    def criterion_gradient(self, q: Expression, parameters: Expression) -> tuple[Expression, Expression]:
        """H, and its derivative with respect to the velocity as a column, of first order only."""
        made = self.once("criterion_gradient", self._criterion_gradient)
        if made is None:
            H = self.criterion(q, parameters)
            return H, self.gradient(H, q)
        H, dH = made(q, parameters)
        return H, self.robot.tangent(q).T @ dH

    def _criterion_gradient(self) -> Function | None:
        """(q, parameters) -> H, dH/dq; None where no criterion has a gradient of its own."""
        q, _, parameters = self.symbols()
        found = self.terms.value_and_gradient(self.robot.at(q), parameters)
        if found is None:
            return None
        # the function that it is written into shares its subexpressions
        return function("criterion_gradient", [q, parameters], list(found), cse=False)

    def report(self) -> Function:
        """(q, target, parameters) -> error, its Jacobian, value of each criterion, dH/dv, residual, its Jacobian."""
        q, target, parameters = self.symbols()
        error, residual = self.error(q, target), self.residual(q, target)
        values = self.values(q, parameters)
        return function(
            "report",
            [q, target, parameters],
            [
                error,
                self.error_jacobian(q, target),
                values,
                self.gradient(sum1(values), q),
                residual,
                self.residual_jacobian(q, target),
            ],
            cse=False,  # it is evaluated once in a solve
        )

    def hessian(self) -> Function:
        """(q, target, parameters, multipliers) -> d2(H + lambda' r)/dv2, (n, n)."""
        q, target, parameters = self.symbols()
        multipliers = symbol("multipliers", self.m)
        second = lagrangian_hessian(
            self.robot,
            self.criterion,
            self.residual,
            q=q,
            target=target,
            parameters=parameters,
            multipliers=multipliers,
        )
        return function("hessian", [q, target, parameters, multipliers], [second], cse=False)  # it takes longest

    def curvature(self, rows: Sequence[int] | None = None) -> Function:
        """(q, target, parameters) -> |J| |r|, dV/dv, d2V/dv2, dH/dv: for configurations where dV/dv is zero.

        Args:
            rows: the rows of the residual in V; None for all.
        """
        q, target, parameters = self.symbols()
        v, chosen = symbol("v", self.robot.n), list(range(self.m) if rows is None else rows)
        moved = self.residual(self.robot.integrate(q, v), target)[chosen]
        V = dot(moved, moved) / 2
        first = gradient(V, v)
        second = jacobian(first, v)
        zero = zeros(self.robot.n)
        return function(
            "curvature",
            [q, target, parameters],
            [
                norm(self.residual_jacobian(q, target)[chosen, :]) * norm(self.residual(q, target)[chosen]),
                substitute(first, v, zero),
                substitute(second, v, zero),
                self.gradient(self.criterion(q, parameters), q),
            ],
            cse=False,  # it would take seconds for a humanoid
        )
