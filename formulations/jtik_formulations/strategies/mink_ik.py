"""mink's own step on the same robot, task, criterion and limits (formulations/mink.md)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from jtik import register_strategy
from jtik.errors import ArgumentError, finite_array
from jtik.strategy import LocalModel, NullMove, Outcome, Shape, State, Strategy, Update
from jtik.symbolic import fmax, fmin, if_else, is_finite, norm, ratio, sumsqr, vertcat, zeros
from jtik.types import Array
from jtik_formulations.strategies.projected_gradient import ProjectedGradient

if TYPE_CHECKING:
    from mink.tasks import BaseTask


@register_strategy("mink")
@dataclass(frozen=True, kw_only=True)
class Mink(Strategy):
    """A step by mink: its kinematics where it has the task, its program, its solver; every step is taken.

    For comparing, and for tasks of mink's own beside jtik's. A pose task is mink's ``FrameTask``; every other task is
    handed over as its residual and Jacobian. Every call goes through Python and costs what mink costs. ``solver=`` of
    InverseKinematics is the name that mink passes on to qpsolvers.

    Attributes:
        strict: tasks of the highest priority as equalities, the rest minimised below them. Where mink finds no
            solution, at a singularity or behind a limit, that step is the soft one. False: always the soft one.
        weight: of the criterion and of mink's own ``tasks`` against 1 of jtik's, where these are soft.
        gain: fraction of the error a step aims to remove, (0, 1].
        lm_damping: mink's damping by the error, of the soft form: |dq|^2 costs this times |e|^2.
        damping: mink's constant damping.
        step_limit: most that each rotation moves in a step [rad]; math.inf for no limit.
        descent: how far down the criterion a step goes: by its rule for beta below strict tasks, beside soft ones by
            its ``beta_max``, since what damps them damps the criterion, too, and would mislead the rule.
        tasks: tasks of mink's to minimise as well, on ``to_mujoco(ik.robot)``. A solve does not wait for them.

    Source: Zakka, mink (2024).
    """

    strict: bool = True
    weight: float = 1e-8
    gain: float = 1.0
    lm_damping: float = 0.1
    damping: float = 1e-12
    step_limit: float = 0.5
    descent: ProjectedGradient = field(default_factory=ProjectedGradient)
    tasks: Sequence[BaseTask] = ()

    summary = "one step of mink's own program, strict or soft, on the same robot"
    source = "Zakka 2024 (mink)"

    def __post_init__(self) -> None:
        if not 0 < self.gain <= 1:
            raise ArgumentError("gain", self.gain, "a number in (0, 1]")
        for name in ("lm_damping", "damping"):
            if not 0 <= getattr(self, name) < math.inf:
                raise ArgumentError(name, getattr(self, name), "a finite number from 0")
        if not finite_array("weight", self.weight, ()) > 0:
            raise ArgumentError("weight", self.weight, "a positive, finite number")
        if not self.step_limit > 0:
            raise ArgumentError("step_limit", self.step_limit, "a positive angle [rad], math.inf for none")
        if self.descent.rule != "merit":
            raise ArgumentError("descent.rule", self.descent.rule, "'merit'")
        for task in self.tasks:
            if not hasattr(task, "compute_qp_objective"):
                raise ArgumentError("tasks", task, "tasks of mink's")

    def uses_qp(self, has_criterion: bool) -> bool:
        """Always: by mink."""
        return True

    def initial_state(self, shape: Shape) -> Mapping[str, Array]:
        """What the rule for beta remembers."""
        return self.descent.initial_state(shape) if self._adapts(shape.has_criterion) else {}

    def _adapts(self, has_criterion: bool) -> bool:
        return self.strict and has_criterion

    def update(self, model: LocalModel, state: State) -> Update:
        """Ask mink, go there."""
        from jtik_formulations.strategies._parts.mink_step import MinkStep  # it takes MuJoCo half a second to load

        robot, n = model.robot, model.robot.n
        if model.tasks is None or model.programs is None:
            raise ArgumentError("model", model, "that of an InverseKinematics")
        down = NullMove(zeros(n), 0, 0, 0)
        if self._adapts(model.has_criterion):
            down = self.descent.propose(model, state, zeros(n))
        elif model.has_criterion:
            beta = fmin(self.descent.beta_max, ratio(self.descent.step_limit, model.null_length))
            down = NullMove(beta * model.null_gradient, beta * model.null_length, beta * model.null_length**2, beta)
        step = MinkStep(
            self,
            robot,
            model.tasks,
            strict_rows=model.levels[0],
            solver=model.programs.solver,
            has_criterion=model.has_criterion,
        )
        cap = [self.step_limit if turns else math.inf for turns in robot.rotational]
        low, high = model.box
        inputs = [
            model.here.q,
            model.target,
            model.here.residual,
            model.full_J,
            down.beta * model.full_gradient,
            vertcat(*[fmax(low[j], -c) for j, c in enumerate(cap)]),
            vertcat(*[fmin(high[j], c) for j, c in enumerate(cap)]),
        ]
        dq, strict = model.compute("mink", step, inputs, [(n, 1), (1, 1)])
        point = model.moved(model.within_limits(-dq))
        outcome = Outcome(1, 1, down, 0, 2 * down.length**2 > sumsqr(dq))  # at right angles to the task's part
        figures = {
            "alpha": math.nan,
            "beta": down.beta,
            "V2": 0,
            "predicted_decrease": math.nan,
            "actual_decrease": model.here.V - point.V,
            "strict": strict,
        }
        return Update(
            point=point,
            accepted=is_finite(point.V + point.H),
            state=self.descent.adapt(model, state, down, outcome) if self._adapts(model.has_criterion) else {},
            term=model.within_limits(-dq),
            wanted=-dq,
            null_term=zeros(n),
            figures=figures,
            stationarity_residual=if_else(down.beta > 0, ratio(norm(dq), down.beta), model.null_length),
        )
