"""Displacements of one update: for the task, in its null space, and the outcome of their sum."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from jtik.symbolic import Expression, dot, fabs, fmax, if_else, logic_and, norm, sqrt, zeros
from jtik.symbolic.factorization import RowVector

if TYPE_CHECKING:
    from jtik.strategy.checked_call import CheckedCall
    from jtik.strategy.model import LocalModel


@dataclass(frozen=True)
class TaskDisplacement:
    """The part of a step that moves the end effector.

    Only ``dq`` is needed. The engine computes ``image`` and ``length`` where they are not given.

    Attributes:
        dq: displacement that is added to q (n, 1).
        image: J_free dq (m, 1).
        length: norm of dq.
        alpha: the gain that a trace reports; NaN without one.
        row_vector: dq in coordinates of the row space of J_free, if it lies there.
    """

    dq: Expression
    image: Expression = None
    length: Expression = None
    alpha: Expression = math.nan
    row_vector: RowVector | None = None

    @classmethod
    def along(cls, step: RowVector, alpha: Expression = math.nan) -> TaskDisplacement:
        """A displacement in the row space of J_free.

        Args:
            step: the displacement in coordinates of the row space.
            alpha: the gain that a trace reports.
        """
        return cls(step.vector, step.image, sqrt(step.squared_length), alpha, step)

    def checked(self, call: CheckedCall, model: LocalModel) -> TaskDisplacement:
        """The same, as what ``call`` returned. Raises StrategyError for a field that cannot be used.

        Args:
            call: the call of a strategy's method that returned it.
            model: the local model at q.
        """
        n, m = model.robot.n, model.J.shape[0]
        return TaskDisplacement(
            dq=call.displacement("dq", self.dq, n),
            image=call.optional("image", self.image, m),
            length=call.optional("length", self.length),
            alpha=call.column("alpha", self.alpha, 1),
            row_vector=None if self.row_vector is None else call.instance("row_vector", self.row_vector, RowVector),
        )

    def completed(self, model: LocalModel) -> TaskDisplacement:
        """The same with image and length filled in.

        Args:
            model: the local model at q.
        """
        image = model.J_free @ self.dq if self.image is None else self.image
        length = norm(self.dq) if self.length is None else self.length
        return TaskDisplacement(self.dq, image, length, self.alpha, self.row_vector)


@dataclass(frozen=True)
class NullSpaceDisplacement:
    """The part of a step that lowers H without moving the end effector, to first order.

    Only ``dq`` is needed.

    Attributes:
        dq: displacement that is added to q (n, 1).
        length: norm of dq.
        decrease: predicted decrease of H to first order, -(dH/dv)' dq.
        beta: the gain that a trace reports; NaN without one.
        stationarity_residual: stationarity residual of H; None for ``model.stationarity_residual``.
        task_scale: share of the task displacement to take, where clearances do not allow all of it.
        task_dq: displacement to take for the task (n, 1) in place of the proposed one; by default the share
            ``task_scale`` of that.
        within_limits: whether both displacements together end inside the limits as they are; if not, the engine
            shortens this one.
        figures: further scalars for the trace, by name.
        relaxed: amount by which each constraint is relaxed, non-negative, by (name, unit).
    """

    dq: Expression
    length: Expression = None
    decrease: Expression = None
    beta: Expression = math.nan
    stationarity_residual: Expression | None = None
    task_scale: Expression = 1
    task_dq: Expression = None
    within_limits: bool = False
    figures: Mapping[str, Expression] = field(default_factory=dict)
    relaxed: Mapping[tuple[str, str], Expression] = field(default_factory=dict)

    @classmethod
    def none(cls, n: int) -> NullSpaceDisplacement:
        """A zero displacement of n velocity entries, for a problem without a criterion.

        Args:
            n: number of velocity entries.
        """
        return cls(zeros(n), 0, 0, 0)

    def checked(self, call: CheckedCall, n: int, prefix: str = "") -> NullSpaceDisplacement:
        """The same, as what ``call`` returned. Raises StrategyError for a field that cannot be used.

        Args:
            call: the call of a strategy's method that returned it.
            n: number of velocity entries.
            prefix: what precedes the names of its fields in an error.
        """
        return NullSpaceDisplacement(
            dq=call.displacement(f"{prefix}dq", self.dq, n),
            length=call.optional(f"{prefix}length", self.length),
            decrease=call.optional(f"{prefix}decrease", self.decrease),
            beta=call.column(f"{prefix}beta", self.beta, 1),
            stationarity_residual=call.optional(f"{prefix}stationarity_residual", self.stationarity_residual),
            task_scale=call.column(f"{prefix}task_scale", self.task_scale, 1),
            task_dq=None if self.task_dq is None else call.displacement(f"{prefix}task_dq", self.task_dq, n),
            within_limits=call.instance(f"{prefix}within_limits", self.within_limits, bool),
            figures=call.figures(f"{prefix}figures", self.figures),
            relaxed=call.relaxed(f"{prefix}relaxed", self.relaxed),
        )

    def completed(self, model: LocalModel) -> NullSpaceDisplacement:
        """The same with length and decrease filled in.

        Args:
            model: the local model at q.
        """
        length = norm(self.dq) if self.length is None else self.length
        decrease = -dot(model.gradient, self.dq) if self.decrease is None else self.decrease
        return replace(self, length=length, decrease=decrease)

    def scaled(self, share: Expression) -> NullSpaceDisplacement:
        """The displacement times ``share``, with length, decrease and gain in proportion.

        Args:
            share: factor of the displacement.
        """
        return replace(
            self,
            dq=share * self.dq,
            length=share * self.length,
            decrease=share * self.decrease,
            beta=share * self.beta,
        )

    def beside(self, model: LocalModel, task_dq: Expression) -> NullSpaceDisplacement:
        """The displacement scaled as a whole so that its sum with ``task_dq`` (n, 1) ends within the limits.

        Args:
            model: the local model at q.
            task_dq: the task displacement (n, 1), within the limits.
        """
        if not (model.bounded and model.has_criterion):
            return self
        scale: Expression = 1
        for i, j in model.bounded:
            step = self.dq[j]
            down, up = (room - task_dq[j] for room in model.room(i, j))
            moves = fabs(step) > 0
            fraction = if_else(step > 0, up, down) / if_else(moves, step, 1)
            blocked = logic_and(moves, fraction < scale)
            scale = if_else(blocked, fmax(fraction, 0), scale)
        return self.scaled(scale)


@dataclass(frozen=True)
class Outcome:
    """The outcome of a proposed step, with which task step and secondary term adapt their states.

    Attributes:
        accepted: 1 if the step is taken, else 0.
        ratio: actual over predicted decrease.
        null_space: the null-space displacement as it was tried.
        shorten_task: 1 if the task displacement is to be shortened after a poor outcome.
        shorten_null_space: 1 if the null-space displacement is. Only the longer of the two is shortened.
    """

    accepted: Expression
    ratio: Expression
    null_space: NullSpaceDisplacement
    shorten_task: Expression
    shorten_null_space: Expression
