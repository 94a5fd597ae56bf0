"""The local model: everything an update law may look at, at one configuration, as shared CasADi expressions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import inf

import numpy as np
from numpy.typing import NDArray

from jtik.constraints.clearance import ClearanceModel
from jtik.errors import JtikError
from jtik.qp.quadratic_program import QPSolution, QuadraticProgram
from jtik.qp.recorder import Compute, QPRecorder
from jtik.robot import Robot
from jtik.strategy.feasibility_restoration import Recovery, recovery
from jtik.symbolic import TINY, Expression, Function, dot, fmax, fmin, norm, sqrt, sumsqr, vertcat
from jtik.symbolic.factorization import RowSpace, RowVector, Split
from jtik.task import TaskStack


@dataclass(frozen=True)
class Point:
    """Task and criterion at one configuration, without derivatives.

    Attributes: q (nq, 1); residual r = L' e with Kp = L L' (m, 1); V = 1/2 |r|^2 = 1/2 e' Kp e; H, the weighted sum
    of the criteria (0 without any).
    """

    q: Expression
    residual: Expression
    H: Expression

    @cached_property
    def V(self) -> Expression:
        """The Lyapunov function of the task, 1/2 e' Kp e."""
        return sumsqr(self.residual) / 2

    @cached_property
    def length(self) -> Expression:
        """|r| = sqrt(2 V)."""
        return norm(self.residual)


@dataclass(frozen=True)
class LocalModel:
    """What an update law sees. ``J`` and ``gradient`` are zero for joints held at their limits.

    Weighting is already inside: with r = L' e and J = L' dx/dv, the paper's e' Kp J ... J' Kp e reads r' J J' r.

    Attributes:
        here: task and criterion at q.
        J: Jacobian of the residual with respect to the velocity v, (m, n).
        gradient: dH/dv, (n, 1); zeros without a criterion.
        has_criterion: whether H can differ from zero at all.
        near: 1 inside the tube about the target in which the criterion is weighed against the task, else 0.
        tube: its size, in the unit of the residual.
        lower, upper: box on the configuration (nq, 1), read only where ``bounded``.
        bounded: (q index, v index) of the joints that have a limit.
        levels: the task rows of each level of priority, the highest first.
        full_J, full_gradient: J and gradient of all joints, those at their limits among them, for laws whose programs
            have the limits as a box.
        clearance: distances that may not fall below their safe values; None without any.
        programs: takes the programs of a law that asks a QP solver.
        tasks: the tasks themselves, for laws that hand them to another library.
    """

    robot: Robot
    here: Point
    J: Expression
    gradient: Expression
    has_criterion: bool
    near: Expression
    tube: Expression
    lower: Expression
    upper: Expression
    bounded: tuple[tuple[int, int], ...]
    levels: tuple[tuple[int, ...], ...]
    residual_function: Function
    criterion_function: Function
    target: Expression
    parameters: Expression
    full_J: Expression = None  # noqa: N815
    full_gradient: Expression = None
    programs: QPRecorder | None = None
    clearance: ClearanceModel | None = None
    tasks: TaskStack | None = None

    def solve(self, program: QuadraticProgram) -> QPSolution:
        """The answer of the solver's back end to a program, as expressions to go on with."""
        if self.programs is None:
            raise JtikError(f"a program of a strategy whose uses_qp() is False: {program.name}")
        return self.programs.solve(program)

    @cached_property
    def recovery(self) -> Recovery:
        """How bodies that are too near are moved out, and the rows of the clearances for every program of the step.

        A law takes a step that ``recovery.takes``, too, and none that ``clearance.keeps`` does not.
        """
        if self.clearance is None or self.programs is None:
            raise JtikError("recovery of a model without clearances, or of a strategy that solves no programs")
        return recovery(
            self.clearance,
            self.programs,
            self.box,
            lambda: self.full_rows.unit_basis,
            self.full_J,
            self.here.length,
        )

    def compute(
        self, name: str, compute: Compute, inputs: Sequence[Expression], shapes: Sequence[tuple[int, int]]
    ) -> list[Expression]:
        """What a Python function answers in the middle of the step, as expressions of these shapes.

        It is given ``inputs`` as flat arrays, columns first, and returns one array a shape, or None where it has no
        answer, which ends the solve with `jtik.Status.UNSOLVED`. Where it is used a step is not one function any more
        and costs what the Python costs.
        """
        if self.programs is None:
            raise JtikError(f"a computation of a strategy whose uses_qp() is False: {name}")
        return self.programs.compute(name, compute, inputs, shapes)

    @cached_property
    def box(self) -> tuple[Expression, Expression]:
        """How far each velocity entry may move down (to 0) and up, (n, 1) each; infinite without a limit."""
        low, high = [-inf] * self.robot.n, [inf] * self.robot.n
        for i, j in self.bounded:
            low[j], high[j] = fmin(self.lower[i] - self.here.q[i], 0), fmax(self.upper[i] - self.here.q[i], 0)
        return vertcat(*low), vertcat(*high)

    @cached_property
    def full_rows(self) -> RowSpace:
        """Row space of the Jacobian of all joints."""
        return RowSpace(self.full_J) if self.bounded else self.rows

    @cached_property
    def full_null_gradient(self) -> Expression:
        """(I - J+ J) dH/dv of all joints, as if none were at a limit, (n, 1)."""
        return self.full_rows.split(self.full_gradient).null if self.bounded else self.null_gradient

    @cached_property
    def rows(self) -> RowSpace:
        """Row space of J: the pseudo-inverse and the null-space projector, factored once."""
        return RowSpace(self.J)

    @cached_property
    def _split(self) -> Split:
        return self.rows.split(self.gradient)

    @cached_property
    def null_gradient(self) -> Expression:
        """h = (I - J+ J) dH/dv: the part of the criterion's gradient that the task leaves free, (n, 1)."""
        return self._split.null

    @cached_property
    def gradient_length(self) -> Expression:
        """|dH/dv|, from its two orthogonal parts."""
        return sqrt(self.null_length**2 + self._split.rest.squared_length)

    @cached_property
    def jacobian_length(self) -> Expression:
        """Frobenius norm of J."""
        return sqrt(self.rows.squared_length + TINY)

    @cached_property
    def null_length(self) -> Expression:
        """|h|."""
        return norm(self.null_gradient)

    @cached_property
    def multipliers(self) -> Expression:
        """(J')+ dH/dv: what a unit of residual is worth in H, (m, 1); minus the Lagrange multipliers."""
        return self._split.multipliers

    @property
    def rotational(self) -> NDArray[np.bool_]:
        """Which velocity entries are rotations, (n,)."""
        return self.robot.rotational

    @cached_property
    def task_gradient(self) -> Expression:
        """dV/dv = J' r: against the joint torques of a spring of stiffness Kp between tip and target, (n, 1)."""
        return self.J.T @ self.here.residual

    @cached_property
    def force(self) -> RowVector:
        """J' r in coordinates of the row space: for laws that factor J anyway."""
        return self.rows.transposed(self.here.residual)

    @cached_property
    def task_slope(self) -> Expression:
        """|J' r|."""
        return sqrt(self.force.squared_length + TINY) if self.has_criterion else norm(self.task_gradient)

    def slope_of_criterion(self, step: RowVector) -> Expression:
        """(dH/dv)' step of a vector in the row space."""
        return self._split.rest.dot(step)

    @cached_property
    def turning(self) -> list[int]:
        """Indices of the velocity entries that are rotations."""
        return [int(i) for i in np.flatnonzero(self.rotational)]

    @property
    def all_rotational(self) -> bool:
        """Whether there is no prismatic joint."""
        return len(self.turning) == self.robot.n

    def rotation_size(self, term: Expression, squared_length: Expression | None = None) -> Expression:
        """The paper's Q: the norm of the rotational part of a step [rad]. The squared norm of all of it saves work."""
        if self.all_rotational and squared_length is not None:
            return sqrt(squared_length)
        return norm(term[self.turning]) if self.turning else 0

    def rotation_dot(self, a: Expression, b: Expression) -> Expression:
        """Inner product of the rotational parts of two steps [rad^2]."""
        return dot(a[self.turning], b[self.turning]) if self.turning else 0

    def residual(self, q: Expression) -> Expression:
        """The residual at another configuration."""
        return self.residual_function(q, self.target)

    def within_limits(self, term: Expression) -> Expression:
        """The term shortened joint by joint so that the step -term ends inside the limits."""
        if not self.bounded:
            return term
        entries = [term[i] for i in range(self.robot.n)]
        for i, j in self.bounded:
            room_down, room_up = self.here.q[i] - self.lower[i], self.here.q[i] - self.upper[i]
            entries[j] = fmin(fmax(entries[j], room_up), room_down)
        return vertcat(*entries)

    def moved(self, term: Expression) -> Point:
        """Task and criterion after the step -term, which must end within the limits."""
        q = self.robot.integrate(self.here.q, -term)
        if self.bounded:  # rounding of q + (limit - q) must not leave the box
            entries = [q[i] for i in range(self.robot.nq)]
            for i, _ in self.bounded:
                entries[i] = fmin(fmax(entries[i], self.lower[i]), self.upper[i])
            q = vertcat(*entries)
        H = self.criterion_function(q, self.parameters) if self.has_criterion else 0
        return Point(q, self.residual(q), H)

    def predicted_decrease(self, image: Expression) -> Expression:
        """Decrease of V that the linear model promises for a step -term with ``image`` = J term."""
        return self.here.V - sumsqr(self.here.residual - image) / 2
