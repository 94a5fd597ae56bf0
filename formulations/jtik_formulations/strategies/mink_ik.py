"""The step of mink on the same robot, task, criterion and limits (formulations/mink.md)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from jtik import register_strategy
from jtik.arguments import several
from jtik.errors import ArgumentError
from jtik.strategy import (
    LocalModel,
    NonNegative,
    NullSpaceDisplacement,
    Positive,
    Programmed,
    Proposal,
    SecondaryTerm,
    Share,
    State,
    StepLimit,
    limited_box,
)
from jtik.symbolic import fmin, if_else, norm, ratio, sumsqr, zeros
from jtik_formulations.bibliography import MINK_2024
from jtik_formulations.strategies.projected_gradient import ProjectedGradient

if TYPE_CHECKING:
    from mink.tasks import BaseTask


@register_strategy("mink")
@dataclass(frozen=True, kw_only=True)
class Mink(Programmed):
    """A step by mink, with its kinematics, its quadratic program and its solver; every step is taken.

    For comparison, and for mink's own tasks beside jtik's. A pose task is mink's ``FrameTask``; every other task is
    passed as its residual and Jacobian. Every call goes through Python and takes as long as mink takes. For a target
    out of reach it does not find the closest posture, but ends up to 0.08 of the reach away from it (a planar arm, 30
    of 30 solves), because every step of mink is taken as it is. ``solver=`` of InverseKinematics is the name that mink
    passes on to qpsolvers.

    Attributes:
        strict: tasks of the highest priority are equalities, the rest is minimised below them. Where mink finds no
            solution, at a singularity or because of a limit, that step uses the soft form. False: every step is soft.
        weight: of the criterion and of mink's own ``tasks`` relative to 1 of jtik's tasks, where these are soft.
        gain: fraction of the error a step aims to remove, (0, 1].
        lm_damping: mink's damping by the error, in the soft form: weight of |dq|^2 is this times |e|^2.
        damping: mink's constant damping.
        step_limit: largest motion of each rotational joint in a step [rad]; math.inf for no limit.
        descent: step length for the criterion: by its rule for beta below strict tasks, by its ``beta_max`` beside soft
            tasks, whose damping also damps the criterion, so that the rule would not apply.
        tasks: tasks of mink to minimise as well, on ``to_mujoco(ik.robot)``. They do not count for convergence.

    Source: Zakka, mink (2024).
    """

    strict: bool = True
    weight: Positive = 1e-8
    gain: Share = 1.0
    lm_damping: NonNegative = 0.1
    damping: NonNegative = 1e-12
    step_limit: StepLimit = 0.5
    descent: ProjectedGradient = field(default_factory=ProjectedGradient)
    tasks: Sequence[BaseTask] = ()

    summary = "one step of mink's own quadratic program, strict or soft, on the same robot"
    source = "Zakka 2024 (mink)"
    bibtex = MINK_2024

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.descent.rule != "merit":
            raise ArgumentError("descent.rule", self.descent.rule, "'merit'")
        object.__setattr__(self, "tasks", several("tasks", self.tasks, "tasks of mink"))
        for task in self.tasks:
            if not hasattr(task, "compute_qp_objective"):
                raise ArgumentError("tasks", task, "tasks of mink")

    def merit(self) -> None:
        """None: every step is taken."""
        return None

    def evaluates_candidate(self, has_criterion: bool) -> bool:
        """Always, to end where something is not finite."""
        return True

    def damps_stagnation(self) -> bool:
        """Always."""
        return True

    def secondary_term(self) -> SecondaryTerm | None:
        """The rule for beta, below strict tasks."""
        return self.descent if self.strict else None

    def propose(self, model: LocalModel, state: State) -> Proposal:
        """The displacement that mink returns."""
        from jtik_formulations.strategies._parts.mink_step import MinkStep  # loading MuJoCo needs half a second

        robot, n = model.robot, model.robot.n
        if model.tasks is None or model.qps is None:
            raise ArgumentError("model", model, "that of an InverseKinematics")
        null, joints = self._descent(model, state), model.coordinates
        step = MinkStep(
            self,
            robot,
            model.tasks,
            strict_rows=model.levels[0],
            solver=model.qps.solver,
            has_criterion=model.has_criterion,
            weights=joints.weights,
            own_error=not model.accelerated,
        )
        # mink's displacement is that of the joints themselves
        box = (joints.to_joints(bound) for bound in limited_box(model, self.step_limit))
        J, gradient = joints.jacobian_by_joints(model.J), joints.gradient_by_joints(null.beta * model.gradient)
        residual, weak = model.here.residual, zeros(n) + model.weak_motion
        if model.accelerated:
            residual = residual + model.J @ weak
        # mink's own task has the error to the target itself; no step is refused, so more joints need more damping
        distant = ratio(model.here.length, norm(model.here.residual))
        curvature = max(1, n / 7) * model.curvature + max(1, n / 3) * distant * model.stagnation_damping
        back = joints.gradient_by_joints(curvature * weak)
        inputs = [model.here.q, model.target, residual, J, gradient, *box, zeros(1) + curvature, back]
        dq, strict = model.compute("mink", step, inputs, [(n, 1), (1, 1)])
        dq = model.within_limits(joints.from_joints(dq))
        residual = model.joint_gradient_norm(dq, norm(dq))
        return Proposal(
            dq=dq,
            null_space_unlimited=null,
            null_space_longer=2 * null.length**2 > sumsqr(dq),  # the two parts are at right angles
            figures={"beta": null.beta, "strict": strict},
            stationarity_residual=if_else(null.beta > 0, ratio(residual, null.beta), model.stationarity_residual),
        )

    def _descent(self, model: LocalModel, state: State) -> NullSpaceDisplacement:
        """The displacement for the criterion, whose gain mink's objective uses."""
        if not model.has_criterion:
            return NullSpaceDisplacement.none(model.robot.n)
        if self.strict:
            return self.descent.propose(model, state, zeros(model.robot.n))
        h, length = model.null_gradient_free, model.null_gradient_norm
        beta = model.null_space_share * fmin(self.descent.beta_max, ratio(self.descent.step_limit, length))
        return NullSpaceDisplacement(-beta * h, beta * length, beta * length**2, beta)
