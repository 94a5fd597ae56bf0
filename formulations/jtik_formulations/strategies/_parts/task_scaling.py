"""Strategies that scale a task displacement in its direction to keep the step within limits (formulations/sns.md)."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass, field
from typing import Protocol

from jtik.errors import ArgumentError
from jtik.strategy import (
    Acceptance,
    Backtracking,
    LevelMerit,
    LocalModel,
    NonNegative,
    NullSpaceDisplacement,
    Programmed,
    Proposal,
    SecondaryTerm,
    Share,
    State,
    StepLimit,
    limited_box,
    not_outward,
)
from jtik.symbolic import (
    Expression,
    diag,
    dot,
    fmin,
    if_else,
    norm,
    ratio,
    sumsqr,
    zeros,
)
from jtik.symbolic.factorization import RowSpace, damped_multipliers
from jtik_formulations.strategies._parts.significance import in_null_space, significant
from jtik_formulations.strategies.projected_gradient import ProjectedGradient

BACKTRACKING = Backtracking()
"""The fraction of a step that is taken."""


class ScaledDisplacement(Protocol):
    """A displacement within a box, to which tasks are added in order of priority, then a null-space displacement."""

    @property
    def x(self) -> Expression:
        """The displacement (n, 1)."""

    @property
    def scale(self) -> Expression:
        """The scale s of the last task, 0 to 1."""

    def with_task(self, J: Expression, change: Expression) -> ScaledDisplacement:
        """Add a task: J x changes by s ``change`` (m, 1); the displacements of earlier tasks are kept."""

    def towards(self, wanted: Expression) -> ScaledDisplacement:
        """Approach ``wanted`` (n, 1), keeping the displacements of all tasks."""


@dataclass(frozen=True, kw_only=True)
class TaskScaling(Programmed):
    """Base class of strategies with task scaling: the task of each level, the box and the criterion.

    Attributes:
        gain: share of the error to remove in a step, in (0, 1].
        damping: damping of the task near singular poses, mu / V [1 / rad^2]; 0 for none.
        q_limit: largest motion of each rotational joint in a step [rad]; math.inf for no limit.
        backtracking: halve the step until V falls, or the penalty function of several levels.
        secondary: rule of beta.
    """

    gain: Share = 1.0
    damping: NonNegative = 0.1
    q_limit: StepLimit = 0.5
    backtracking: bool = True
    secondary: ProjectedGradient = field(default_factory=ProjectedGradient)

    def __post_init__(self) -> None:
        super().__post_init__()
        if type(self.secondary) is not ProjectedGradient or self.secondary.rule != "merit":
            raise ArgumentError("secondary", self.secondary, "a ProjectedGradient(rule='merit'), whose gain is used")

    @abstractmethod
    def initial(self, model: LocalModel, lower: Expression, upper: Expression) -> ScaledDisplacement:
        """The displacement 0 in the box with these bounds, (n, 1) each."""

    def releases(self) -> bool:
        """Whether ``towards`` can release joints from their bounds; if not, the engine's active set does."""
        return True

    def respects_priority(self) -> bool:
        """Always."""
        return True

    def merit(self) -> LevelMerit:
        """The penalty function of the levels; with one level it is |r|."""
        return LevelMerit()

    def acceptance(self) -> Acceptance:
        """By merit, or always without backtracking."""
        return "merit" if self.backtracking else "always"

    def shortening(self) -> Backtracking:
        """Backtracking."""
        return BACKTRACKING

    def secondary_term(self) -> SecondaryTerm:
        """The rule of beta."""
        return self.secondary

    def uses_qp(self, has_criterion: bool) -> bool:
        """Never, unless a subclass does."""
        return False

    def propose(self, model: LocalModel, state: State) -> Proposal:
        """All levels, the highest first, then the criterion."""
        fraction = BACKTRACKING.fraction(state) if self.backtracking else 1
        here, unlimited, shares = self._tasks(model, self.initial(model, *limited_box(model, self.q_limit, fraction)))
        task, null, proposed = fraction * here.x, None, None
        if model.has_criterion:
            proposed, wanted_null = self._null_space(model, state, here)
            null = proposed.scaled(fraction)
            unlimited = unlimited + wanted_null
        return Proposal(
            dq=model.within_limits(task + null.dq if null else task),
            task=task,
            null_space=null,
            null_space_unlimited=proposed,
            wanted=unlimited,
            figures={f"scale_{k}": share for k, share in enumerate(shares)},
        )

    def _tasks(
        self, model: LocalModel, here: ScaledDisplacement
    ) -> tuple[ScaledDisplacement, Expression, list[Expression]]:
        """The displacement of all levels, the highest first; their displacement without limits; the scale of each."""
        unlimited, shares, above = zeros(model.robot.n), list[Expression](), list[int]()
        for level in model.levels:
            rows = list(level)
            J, r = model.J[rows, :], model.here.residual[rows]
            error = self.gain * r + J @ here.x
            # a single level uses the engine's active set, which considers all levels together
            free = not_outward(model, J.T @ error) if len(model.levels) > 1 else None
            own = model.J_free[rows, :] if free is None else J @ diag(free)
            if above:
                basis = RowSpace(model.J[above, :] @ diag(free)).unit_basis
                own = own - (own @ basis.T) @ basis
            damping = self.damping * sumsqr(r) / 2 + model.curvature
            part = -(own.T @ damped_multipliers(own, damping, error))
            if not above:
                part = part - model.weak_motion
            here = here.with_task(J, own @ part)
            unlimited = unlimited + part
            shares.append(here.scale)
            above += rows
        return here, unlimited, shares

    def _null_space(
        self, model: LocalModel, state: State, here: ScaledDisplacement
    ) -> tuple[NullSpaceDisplacement, Expression]:
        """The displacement for the criterion, and what it would be without limits (n, 1)."""
        releases = self.releases()
        h = model.null_gradient if releases else model.null_gradient_free
        length = norm(h)
        known = self.secondary.gain.gain(model, state, model.null_gradient_free)
        beta = fmin(if_else(known > 0, known, self.secondary.beta_max), ratio(state["null_cap"], length))
        beta = model.null_space_share * beta
        wanted_null = -beta * h
        dq = significant(length, norm(model.gradient)) * (here.towards(wanted_null).x - here.x)
        moved = norm(dq)
        kept = in_null_space(model.row_space.unit_basis, dq, here.x)
        null = NullSpaceDisplacement(
            dq=kept * dq,
            length=kept * moved,
            decrease=-kept * dot(model.gradient, dq),
            beta=beta,
            stationarity_residual=ratio(model.joint_gradient_norm(dq, moved), beta) if releases else None,
        )
        return null, wanted_null
