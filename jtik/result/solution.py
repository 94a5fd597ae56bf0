"""Results that explain themselves: why a solve stopped, what it reached, and how it got there."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from jtik._step.relaxation import Relaxation
from jtik.result.report import Report, SecondOrder
from jtik.types import Array


class Status(Enum):
    """Why a solve stopped. The value is the sentence a Solution prints."""

    CONVERGED = "converged: on target, and the criterion cannot fall further without leaving it"
    REACHED = "reached the target; the criterion could still fall"
    LOCAL_MINIMUM = "out of reach, or a local minimum of the error: this is the closest posture nearby"
    LIMITS = "held by joint limits: the error could fall if the joints at their limits could move on"
    BLOCKED = "held by clearances: the error could fall if bodies might come nearer to the obstacles"
    SINGULAR = "stopped at a singularity: no direction the robot can move in brings the target nearer"
    STALLED = "stalled: no step the strategy tried brought the target nearer"
    ITERATION_LIMIT = "reached the iteration limit before the target"
    UNSOLVED = "a quadratic program of the step has no answer: contradictory rows, not convex, or its solver failed"
    NOT_FINITE = "error or criterion is not a finite number here; q is the last configuration where they were"


def is_success(status: Status, until: str) -> bool:
    """Whether a solve that was to go on ``until`` then has done what was asked."""
    return status is Status.CONVERGED or (status is Status.REACHED and until == "reached")


@dataclass(frozen=True)
class Trace:
    """What happened, iteration by iteration. Row k belongs to the call that started at ``q[k]``.

    Attributes:
        q: configurations, (iterations + 1, nq): the last row is where the solve ended.
        error: norm of the task error at ``q[k]``, in [m] and [rad] together, (iterations + 1,).
        figures: one array a figure, (iterations,): V, H, V2, alpha, beta, predicted_decrease and actual_decrease of V,
            accepted, null_residual, sigma_min (of the weighted Jacobian of the joints that were free to move),
            leakage (``|J nu| / |nu|`` of the null-space step nu; NaN where it is below 1e-8), step_length, escaped (1
            where the iteration ended in a second-order step out of a singular stall), attempt (0 from the caller's
            start, then one more for each attempt that began elsewhere). A law without a gain has NaN. With clearances
            too_near, the most that a distance lacks of safe + margin [m], and task_share, how much of the task step
            there was room for; with elastic rows slack, the most by which one gave way.
    """

    q: Array
    error: Array
    figures: Mapping[str, Array]

    def __getattr__(self, name: str) -> Array:
        figures: Mapping[str, Array] = object.__getattribute__(self, "figures")
        if name in figures:
            return figures[name]
        raise AttributeError(f"a trace has q, error, {', '.join(figures)}; not {name!r}")

    def __len__(self) -> int:
        return len(self.q) - 1


@dataclass(frozen=True, eq=False, repr=False)
class Solution:
    """Where a solve ended and why.

    Attributes:
        q: configuration, (nq,) [rad] and [m].
        status: why it stopped; ``status.value`` is a sentence.
        converged: whether what was asked for was achieved (with ``until="reached"``, arriving is enough).
        iterations: steps tried, accepted or not, in all attempts together.
        escapes: how often a singular stall was left by a second-order step.
        restarts: how many other starts were tried.
        seconds: wall time of the solve [s].
        look: what to call for ``report``.
        trace: the iterations, when asked for.
    """

    q: Array
    status: Status
    converged: bool
    iterations: int
    escapes: int
    restarts: int
    seconds: float
    look: Callable[[], Report]
    trace: Trace | None = None

    @classmethod
    def of(cls, **fields: Any) -> Solution:
        """As the constructor, for keywords alone and in a quarter of the time: a frozen dataclass sets one by one."""
        solution = object.__new__(cls)
        solution.__dict__.update(fields)
        return solution

    @cached_property
    def report(self) -> Report:
        """Task and criteria at q, evaluated when first asked for; the properties below read it."""
        return self.look()

    def __reduce__(self) -> tuple[Any, ...]:
        # the report travels, the solver it could have come from stays
        return type(self), (
            self.q,
            self.status,
            self.converged,
            self.iterations,
            self.escapes,
            self.restarts,
            self.seconds,
            Told(self.report),
            self.trace,
        )

    @property
    def error(self) -> Array:
        """Task error e at q, (m,), rows in [m] or [rad]."""
        return self.report.error

    @property
    def position_error(self) -> float:
        """Norm of the error's position rows [m]."""
        return self.report.position_error

    @property
    def orientation_error(self) -> float:
        """Norm of the error's orientation rows [rad]."""
        return self.report.orientation_error

    @property
    def cost(self) -> float:
        """H at q, the weighted sum of the criteria."""
        return sum(self.report.values.values())

    @property
    def criteria(self) -> Mapping[str, float]:
        """Weighted value of each criterion by name."""
        return self.report.values

    @property
    def jacobian(self) -> Array:
        """Jacobian of the task error with respect to the velocity, (m, n)."""
        return self.report.jacobian

    @property
    def gradient(self) -> Array:
        """Gradient of H with respect to the velocity, (n,)."""
        return self.report.gradient

    @property
    def null_space_residual(self) -> float:
        """Norm of (I - J+ J) dH/dv over the joints that no limit holds, in the unit of H per [rad] or [m]."""
        return self.report.null_space_residual

    @property
    def second_order(self) -> SecondOrder | None:
        """What second derivatives say of H on the task's solutions: "minimum", "saddle" (or maximum) or "flat".

        By the eigenvalues of the Hessian of H + lambda' r over the self-motions that active limits leave. "flat" is
        where the lowest is zero, as along a valley. None without a criterion, off the target, or where H is not
        stationary.
        """
        return self.report.second_order

    @property
    def relaxed(self) -> tuple[Relaxation, ...]:
        """What was asked for and cannot be had at q: name, amount and unit each; empty where nothing gave way.

        As the strategy's first step from q would find it: the task's share that clearances leave no room for,
        clearances that cannot be kept, levels of priority that limits keep from their aim, elastic rows of programs.
        CompiledFunction and worked out when first asked for.
        """
        return self.report.relaxed

    @property
    def active_limits(self) -> tuple[str, ...]:
        """Names of the joints that stand at a limit."""
        return self.report.active_limits

    @cached_property
    def condition(self) -> float:
        """Condition number of the task's Jacobian; infinite at a singular pose, NaN where it is not finite."""
        if not np.isfinite(self.jacobian).all():
            return float("nan")
        sigma = np.linalg.svd(self.jacobian, compute_uv=False)
        return float(sigma[0] / sigma[-1]) if sigma[-1] > np.finfo(float).eps * sigma[0] else float("inf")

    def __repr__(self) -> str:
        lines = [
            f"Solution: {self.status.value}",
            f"  q           {np.array2string(self.q, precision=4, suppress_small=True, max_line_width=100)}",
            f"  error       {self.position_error:.3g} m, {self.orientation_error:.3g} rad",
            f"  iterations  {self.iterations} in {1e3 * self.seconds:.3g} ms",
            f"  condition   {self.condition:.3g}",
        ]
        if self.escapes:
            lines.append(f"  escapes     {self.escapes} from a singular stall, by a second-order step")
        if self.restarts:
            lines.append(f"  restarts    {self.restarts} from other configurations")
        if self.criteria:
            terms = ", ".join(f"{name} {value:.4g}" for name, value in self.criteria.items())
            lines.append(f"  H           {self.cost:.6g} ({terms}); null-space residual {self.null_space_residual:.2g}")
        if self.active_limits:
            lines.append(f"  at limit    {', '.join(self.active_limits)}")
        if self.relaxed:
            lines.append(f"  gave way    {', '.join(map(str, self.relaxed))}")
        return "\n".join(lines)


@dataclass(frozen=True)
class Told:
    """A report that is there already, as something to call."""

    report: Report

    def __call__(self) -> Report:
        """The report."""
        return self.report


class Step(NamedTuple):
    """One update: for controllers.

    Attributes:
        q: configuration after the step, (nq,).
        position_error, orientation_error: norms of the task error there [m], [rad].
        accepted: whether the step was taken; a refused one leaves q, and the next call tries a smaller one.
        done: whether there is nothing left to do at the tolerances asked for.
        escaped: whether a singular stall was left by a second-order step.
    """

    q: Array
    position_error: float
    orientation_error: float
    accepted: bool
    done: bool
    escaped: bool
