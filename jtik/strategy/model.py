"""The local model: task, criterion and limits at one configuration, as CasADi expressions that a strategy uses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import inf

import numpy as np
from numpy.typing import NDArray

from jtik.constraints.clearance import ClearanceModel
from jtik.criterion.least_squares import LeastSquares
from jtik.errors import ArgumentError, JtikError
from jtik.qp.fitting import fitted_by
from jtik.qp.quadratic_program import QPSolution, QuadraticProgram
from jtik.qp.recorder import Compute, QPRecorder
from jtik.robot import UNWEIGHTED, Robot, WeightedCoordinates
from jtik.strategy.evaluation import Evaluation
from jtik.strategy.feasibility_restoration import FeasibilityRestoration, feasibility_restoration
from jtik.symbolic import TINY, Expression, Function, dot, fmax, fmin, norm, norm_inf, sqrt, vertcat
from jtik.symbolic.factorization import RowSpace, RowVector, Split
from jtik.task import TaskStack


@dataclass(frozen=True)
class LocalModel:
    """Task, criterion, limits and clearances at one configuration, for a strategy.

    Residual and Jacobian contain the weighting: with r = L' e and J = L' dx/dv, the paper's e' Kp J J' Kp e is
    r' J J' r.

    ``J`` and ``gradient`` are those of all joints. ``J_free`` and ``gradient_free`` are zero for the joints whose limit
    is active. Use the first pair in a quadratic program that has the limits as its box, which finds the active limits
    by itself; use the second in a strategy that ignores limits, such as a pseudo-inverse; the engine's active set then
    handles them. Without limits both pairs are the same.

    With joint weights, every displacement, derivative and bound is in the coordinates z = W^(1/2) dq, in which all
    joints weigh the same, and a strategy needs to know no more (formulations/weights.md). ``coordinates`` converts
    where it needs an angle, a length or a derivative of the joints themselves.

    Attributes:
        robot: the robot.
        here: task and criterion at q.
        J: Jacobian of the residual with respect to the velocity (m, n), of all joints.
        gradient: dH/dv (n, 1) of all joints; zeros without a criterion.
        J_free: J with zero columns for the joints whose limit is active.
        gradient_free: the gradient with zeros for these joints.
        has_criterion: whether H can differ from zero at all.
        near_target: 1 in the neighbourhood of the target in which the criterion counts beside the task, else 0.
        neighbourhood: radius of that neighbourhood, in the unit of the residual.
        lower: lower limits of q (nq, 1), valid only where ``bounded``.
        upper: upper limits of q (nq, 1), valid only where ``bounded``.
        position_limits: lower and upper position limits of q, (nq, 1) each, also in a timed step, whose ``lower`` and
            ``upper`` are the limits of the step; None where they are these.
        bounded: (q index, v index) of the joints that have a limit.
        levels: the task rows of each level of priority, the highest first.
        residual_function: (q, target) -> residual.
        criterion_function: (q, parameters) -> H.
        target: target of the tasks.
        parameters: live parameters of criteria and clearances.
        qps: records the quadratic programs; None for a strategy without any.
        clearance: distances that may not fall below their safe values; None without any.
        tasks: the tasks themselves, for strategies that hand them to another library.
        timed: whether the step has a duration, and so limits of velocity and acceleration in its box.
        accelerated: whether a timed step has limits of acceleration: from its start its box is one of changes of the
            motion, and ``here.residual`` is the part of the error for which the joints can stop in time.
        weak_motion: displacement along weak directions (n, 1) that a step with limits of acceleration subtracts from
            its own; 0 otherwise. It damps the motion that the task cannot stop.
        curvature: size of the curvature of V that J' J leaves out, from the error that the last step left, in a timed
            step; 0 otherwise. As damping it keeps a step along a weak direction from overshooting.
        stagnation_damping: the same in a step without a time whose error no longer falls; for `damps_stagnation`.
        null_space_share: share of a null-space displacement to take in this step, (0, 1]; 1 in a step without a time.
        coordinates: of the displacements, from the joint weights.
        exploring: 1 in an exploring step, which is taken wherever it ends, else 0. Only for a strategy that explores.
        unshifted_function: (q, target) -> `Evaluation.unshifted`; None where it is the residual.
        weights: what a step towards a distant target multiplies the rows of the residual to the target by (m, 1).
        least_squares: the criteria that are in residual form, for `lagrangian_hessian`; None without any.
        shift: what it subtracts from them then (m, 1); None, as ``weights``, where no target can be distant.
    """

    robot: Robot
    here: Evaluation
    J: Expression
    gradient: Expression
    J_free: Expression
    gradient_free: Expression
    has_criterion: bool
    near_target: Expression
    neighbourhood: Expression
    lower: Expression
    upper: Expression
    bounded: tuple[tuple[int, int], ...]
    levels: tuple[tuple[int, ...], ...]
    residual_function: Function
    criterion_function: Function
    target: Expression
    parameters: Expression
    qps: QPRecorder | None = None
    clearance: ClearanceModel | None = None
    tasks: TaskStack | None = None
    timed: bool = False
    accelerated: bool = False
    weak_motion: Expression = 0
    curvature: Expression = 0
    stagnation_damping: Expression = 0
    null_space_share: Expression = 1
    coordinates: WeightedCoordinates = UNWEIGHTED
    exploring: Expression = 0
    unshifted_function: Function = None
    weights: Expression = None
    shift: Expression = None
    least_squares: LeastSquares | None = None
    position_limits: tuple[Expression, Expression] | None = None

    # -- quadratic programs ---------------------------------------------------------------------------------------

    def solve(self, qp: QuadraticProgram) -> QPSolution:
        """The solution of the quadratic program ``qp``, as expressions.

        Raises:
            JtikError: for a strategy whose ``uses_qp()`` is False, or what is no `jtik.qp.QuadraticProgram`.
        """
        if self.qps is None:
            raise JtikError(f"quadratic program {qp.name!r} of a strategy whose uses_qp() is False")
        if not isinstance(qp, QuadraticProgram):
            raise ArgumentError("qp", qp, "a jtik.qp.QuadraticProgram")
        return self.qps.solve(qp)

    def compute(
        self, name: str, compute: Compute, inputs: Sequence[Expression], shapes: Sequence[tuple[int, int]]
    ) -> list[Expression]:
        """The results of a Python function that is called within the step, as expressions of these shapes.

        A step with such a call is no longer a single compiled function.

        Args:
            name: name of the computation.
            compute: called with ``inputs`` as flat arrays, columns first. It returns one array for each shape, or
                None if it has no result, which ends the solve with `jtik.Status.UNSOLVED`.
            inputs: expressions whose values it needs.
            shapes: shapes of its results.

        Raises:
            JtikError: for a strategy whose ``uses_qp()`` is False.
        """
        if self.qps is None:
            raise JtikError(f"computation {name!r} of a strategy whose uses_qp() is False")
        if not callable(compute):
            raise ArgumentError("compute", compute, "a function of flat arrays")
        return self.qps.compute(name, compute, inputs, shapes)

    @cached_property
    def box(self) -> tuple[Expression, Expression]:
        """Bounds of dq by the joint limits, lower <= 0 <= upper, (n, 1) each; infinite without a limit."""
        low, high = [-inf] * self.robot.n, [inf] * self.robot.n
        for i, j in self.bounded:
            down, up = self.room(i, j)
            low[j], high[j] = fmin(down, 0), fmax(up, 0)
        return vertcat(*low), vertcat(*high)

    def room(self, i: int, j: int) -> tuple[Expression, Expression]:
        """Room of entry ``j`` of a displacement, down and up, to the limits of q_i; ``i``, ``j`` as in ``bounded``."""
        down, up = self.lower[i] - self.here.q[i], self.upper[i] - self.here.q[i]
        return self.coordinates.entry(j, down), self.coordinates.entry(j, up)

    @cached_property
    def restoration(self) -> FeasibilityRestoration:
        """The step that restores clearances that are too small, and the rows of all clearances for a QP.

        The engine accepts a step for which ``restoration.accepts`` is 1, and no step for which ``clearance.keeps`` is
        0.

        Raises:
            JtikError: without clearances, or for a strategy whose ``uses_qp()`` is False.
        """
        if self.clearance is None or self.qps is None:
            raise JtikError("feasibility restoration without clearances, or of a strategy whose uses_qp() is False")
        return feasibility_restoration(
            self.clearance, self.qps, self.box, lambda: self.row_space.unit_basis, self.J, self.here.length
        )

    # -- all joints -----------------------------------------------------------------------------------------------

    @cached_property
    def row_space(self) -> RowSpace:
        """Row space of J: its pseudo-inverse and null-space projector."""
        return RowSpace(self.J) if self.bounded else self.row_space_free

    @cached_property
    def null_gradient(self) -> Expression:
        """(I - J+ J) dH/dv of all joints, (n, 1)."""
        return self.row_space.split(self.gradient).null if self.bounded else self.null_gradient_free

    # -- free joints ----------------------------------------------------------------------------------------------

    @cached_property
    def row_space_free(self) -> RowSpace:
        """Row space of J_free: its pseudo-inverse and null-space projector, factored once."""
        return RowSpace(self.J_free)

    @cached_property
    def _split(self) -> Split:
        return self.row_space_free.split(self.gradient_free)

    @cached_property
    def null_gradient_free(self) -> Expression:
        """h = (I - J+ J) dH/dv of the free joints: the part of the gradient that the task leaves free, (n, 1)."""
        return self._split.null

    @cached_property
    def null_gradient_norm(self) -> Expression:
        """|h|, of the free joints."""
        return norm(self.null_gradient_free)

    @cached_property
    def gradient_norm(self) -> Expression:
        """|dH/dv| of the free joints, from its two orthogonal parts."""
        return sqrt(self.null_gradient_norm**2 + self._split.rest.squared_length)

    @cached_property
    def stationarity_residual(self) -> Expression:
        """|h| as a derivative by the joints themselves: what the optimality tolerance is for."""
        return self.joint_gradient_norm(self.null_gradient_free, self.null_gradient_norm)

    def joint_gradient_norm(self, gradient: Expression, length: Expression | None = None) -> Expression:
        """The norm of a ``gradient`` (n, 1) as a derivative by the joints themselves; ``length`` is its own norm."""
        if self.coordinates.scale is None and length is not None:
            return length
        return norm(self.coordinates.gradient_by_joints(gradient))

    @cached_property
    def jacobian_norm(self) -> Expression:
        """Frobenius norm of J_free."""
        return sqrt(self.row_space_free.squared_length + TINY)

    @cached_property
    def multipliers(self) -> Expression:
        """(J')+ dH/dv of the free joints (m, 1): the negative Lagrange multipliers of the task."""
        return self._split.multipliers

    @cached_property
    def task_gradient(self) -> Expression:
        """dV/dv = J' r of the free joints, (n, 1)."""
        return self.J_free.T @ self.here.residual

    @cached_property
    def task_gradient_rows(self) -> RowVector:
        """J' r of the free joints in coordinates of the row space, for strategies that factor J anyway."""
        return self.row_space_free.transposed(self.here.residual)

    @cached_property
    def task_gradient_norm(self) -> Expression:
        """|J' r| of the free joints."""
        if self.has_criterion:
            return sqrt(self.task_gradient_rows.squared_length + TINY)
        return norm(self.task_gradient)

    def criterion_change(self, step: RowVector) -> Expression:
        """(dH/dv)' ``step``, of a step in the row space of J_free."""
        return self._split.rest.dot(step)

    # -- rotations ------------------------------------------------------------------------------------------------

    @property
    def rotational(self) -> NDArray[np.bool_]:
        """Which velocity entries are rotations, (n,)."""
        return self.robot.rotational

    @cached_property
    def rotational_entries(self) -> list[int]:
        """Indices of the velocity entries that are rotations."""
        return [int(i) for i in np.flatnonzero(self.rotational)]

    @property
    def all_rotational(self) -> bool:
        """Whether every velocity entry is a rotation and weighs the same: Q is then the norm of the displacement."""
        joints = self.coordinates
        return len(self.rotational_entries) == self.robot.n and (joints.scale is None or joints.bounds_steps)

    def rotation_norm(self, dq: Expression, squared_length: Expression | None = None) -> Expression:
        """The paper's Q: the norm of the rotational part of a displacement [rad].

        Args:
            dq: displacement (n, 1).
            squared_length: its squared norm, used where ``all_rotational``.
        """
        if self.all_rotational and squared_length is not None:
            return sqrt(squared_length)
        return norm(self._rotation(dq)) if self.rotational_entries else 0

    def rotation_dot(self, a: Expression, b: Expression) -> Expression:
        """Inner product of the rotational parts of two displacements ``a`` and ``b``, (n, 1) each, [rad^2]."""
        return dot(self._rotation(a), self._rotation(b)) if self.rotational_entries else 0

    def _rotation(self, dq: Expression) -> Expression:
        """The rotational part of a displacement [rad]."""
        return self.coordinates.to_joints(dq)[self.rotational_entries]

    # -- candidates -----------------------------------------------------------------------------------------------

    def residual(self, q: Expression) -> Expression:
        """The residual (m, 1) at another configuration ``q`` (nq, 1)."""
        to_target = self.residual_function(q, self.target)
        return to_target if self.shift is None else self.weights * to_target - self.shift

    def within_limits(self, dq: Expression) -> Expression:
        """The displacement ``dq`` (n, 1) shortened joint by joint so that it ends inside the limits, (n, 1)."""
        if not self.bounded:
            return dq
        entries = [dq[i] for i in range(self.robot.n)]
        for i, j in self.bounded:
            low, high = self.room(i, j)
            entries[j] = fmax(fmin(entries[j], high), low)
        return vertcat(*entries)

    def fitted(self, dq: Expression) -> Expression:
        """The task displacement ``dq`` (n, 1) fitted into the limits.

        In a timed step the end effector keeps its direction and moves as far as the limits allow: the unsaturated
        joints compensate for the saturated ones. With limits of acceleration, and one level of priority, the error is
        the smallest that they allow (formulations/motion.md). Otherwise it is shortened joint by joint.
        """
        clipped = self.within_limits(dq)
        if self.qps is None or not (self.timed and self.bounded):
            return clipped
        low, high = self.box
        inside = norm_inf(clipped - dq) <= 0
        by_qp, direct = fitted_by(*self.J.shape, least_error=self.accelerated and len(self.levels) == 1)
        return self.qps.evaluate("fitting", by_qp, [self.J, dq, low, high], (dq, inside), direct)

    def candidate(self, dq: Expression) -> Evaluation:
        """Task and criterion after the displacement ``dq`` (n, 1), which must end within the limits."""
        q = self.robot.integrate(self.here.q, self.coordinates.to_joints(dq))
        if self.bounded:  # rounding of q + (limit - q) must not leave the box
            entries = [q[i] for i in range(self.robot.nq)]
            for i, _ in self.bounded:
                entries[i] = fmin(fmax(entries[i], self.lower[i]), self.upper[i])
            q = vertcat(*entries)
        H = self.criterion_function(q, self.parameters) if self.has_criterion else 0
        unshifted = self.unshifted_function(q, self.target) if self.unshifted_function else None
        whole = None if self.shift is None else self.residual_function(q, self.target)
        if whole is not None and unshifted is not None:
            unshifted = self.weights * unshifted
        return Evaluation(q, self.residual(q), H, dq, unshifted, whole)

    def predicted_decrease(self, image: Expression) -> Expression:
        """Decrease of V that the linear model predicts for a displacement with ``image`` = J dq (m, 1)."""
        return -dot(image, self.here.residual + image / 2)
