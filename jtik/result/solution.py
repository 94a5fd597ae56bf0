"""The result of a solve: where it ended, why, and the figures of that configuration."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from jtik.result.deprecated import RenamedAttribute
from jtik.result.relaxation import Relaxation
from jtik.result.report import Report
from jtik.result.second_order import SecondOrder
from jtik.result.status import Status
from jtik.result.step import Step
from jtik.result.trace import Trace
from jtik.types import Array

__all__ = ["Solution", "Status", "Step", "Trace"]

TRY = "restarts=, or another q0: another start may lead to the target"
"""What a Solution says where the status depends on the start and no other one was tried."""


@dataclass(frozen=True, eq=False, repr=False)
class Solution:
    """Where a solve ended and why. ``bool(solution)`` is `converged`.

    It can be pickled and read in any thread. `report`, what depends on it, and the status of a failed solve are
    computed when first read.

    Attributes:
        q: configuration, (nq,) [rad] and [m].
        status: why the solve stopped; ``status.value`` is a sentence.
        converged: whether the solve succeeded; with ``until="reached"`` the criterion need not be stationary.
        iterations: steps tried, accepted or not, in all attempts together.
        escapes: how many escapes from saddle points there were, of the error or of the criterion.
        restarts: how many other starting configurations were tried.
        seconds: wall time of the solve [s].
        inspect: function that computes `report`.
        trace: the iterations, with ``trace=True``; else None.
        alternatives: with ``best_of``, the other Solutions that were found, the best first.
        evaluations: how often functions of numeric criteria and their gradients were called, for differences and the
            status, too; not counted in a batch.

    Example:
        >>> ik = jtik.InverseKinematics(jtik.Robot.planar(2), jtik.FrameTask("tip"))
        >>> solution = ik.solve([3.0, 0.0], q0=[0.3, 0.4])
        >>> bool(solution), solution.status.name, round(solution.position_error, 3)
        (False, 'LOCAL_MINIMUM', 1.0)
    """

    q: Array
    status: Status
    converged: bool
    iterations: int
    escapes: int
    restarts: int
    seconds: float
    inspect: Callable[[], Report]
    trace: Trace | None = None
    alternatives: tuple[Solution, ...] = ()
    evaluations: int = 0

    look = RenamedAttribute("inspect")
    gave_way = RenamedAttribute("relaxed")

    @classmethod
    def of(cls, **fields: Any) -> Solution:
        """As the constructor, for all fields as keywords, in a quarter of the time.

        Instead of ``status`` it accepts ``diagnose``, a function that computes it when it is first read.

        Args:
            fields: all fields of the constructor, as keywords.
        """
        solution = object.__new__(cls)
        solution.__dict__.update(fields)
        return solution

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            diagnose = self.__dict__.get("diagnose") if name == "status" else None
            if diagnose is None:
                raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
            status = self.__dict__["status"] = diagnose()
            return status

    def __bool__(self) -> bool:
        return self.converged

    @cached_property
    def report(self) -> Report:
        """Task and criteria at q; the properties below read it."""
        return self.inspect()

    def __reduce__(self) -> tuple[Any, ...]:
        # the report is pickled, the solver that computed it is not
        return type(self), (
            self.q,
            self.status,
            self.converged,
            self.iterations,
            self.escapes,
            self.restarts,
            self.seconds,
            ComputedReport(self.report),
            self.trace,
            self.alternatives,
            self.evaluations,
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
        """Norm of (I - J+ J) dH/dv over the joints whose limit is not active, in the unit of H per [rad] or [m]."""
        return self.report.null_space_residual

    @property
    def multipliers(self) -> Array:
        """Multipliers lambda of the task in H, (m,): dH/dv + J' lambda = 0 but for what limits take.

        With the status COMPROMISE the error is them times the criterion's weight: by them it shrinks with the weight.
        """
        return self.report.multipliers

    @property
    def second_order(self) -> SecondOrder | None:
        """Kind of the stationary point of H on the task's solutions: "minimum", "saddle" (or maximum) or "flat".

        It follows from the eigenvalues of the Hessian of H + lambda' r over the self-motions that active limits leave.
        "flat" means that the lowest is zero, as along a valley, or that second derivatives do not decide, as at some
        singular poses. None without a criterion, off the target, or where H is not stationary. A solve leaves a saddle
        where limits and clearances let it; otherwise the status is SADDLE.
        """
        return self.report.second_order

    @property
    def relaxed(self) -> tuple[Relaxation, ...]:
        """Constraints that are relaxed at q, each with name, amount and unit; empty where all are met.

        They are those of the strategy's first step from q: the share of the task step that clearances do not allow,
        clearances that cannot be kept, priority levels that limits keep from their aim, and elastic rows of quadratic
        programs.
        """
        return self.report.relaxed

    @property
    def unused(self) -> str | None:
        """The part of the target that the tasks do not use, such as "orientation of the target", or None."""
        return self.report.unused

    @property
    def active_limits(self) -> tuple[str, ...]:
        """Names of the joints at a limit."""
        return self.report.active_limits

    @property
    def active_clearances(self) -> tuple[str, ...]:
        """Names of the pairs of body and obstacle whose distance is within twice the margin of its safe value.

        With the status BLOCKED they are what the error could fall without.
        """
        return self.report.active_clearances

    @cached_property
    def condition(self) -> float:
        """Condition number of the task's Jacobian; infinite at a singular pose, NaN where it is not finite."""
        if not np.isfinite(self.jacobian).all():
            return float("nan")
        sigma = np.linalg.svd(self.jacobian, compute_uv=False)
        return float(sigma[0] / sigma[-1]) if sigma[-1] > np.finfo(float).eps * sigma[0] else float("inf")

    def plot(self, robot: Any, **options: Any) -> Any:
        """A figure of the robot at q: `jtik.plotting.posture_figure`.

        Example::

            solution = ik.solve(target)
            solution.plot(ik.robot, obstacles=field).savefig("posture.pdf")

        Args:
            robot: the robot whose configuration q is, ``ik.robot``.
            options: those of `posture_figure`.

        Returns:
            A matplotlib Figure, which a notebook shows.

        Raises:
            ArgumentError: when an argument cannot be used.
            MissingExtraError: when matplotlib is not installed.
        """
        return import_module("jtik.plotting").posture_figure(robot, self, **options)

    def __repr__(self) -> str:
        lines = [
            f"Solution: {self.status.value}",
            f"  q           {np.array2string(self.q, precision=4, suppress_small=True, max_line_width=100)}",
            f"  error       {self.position_error:.3g} m, {self.orientation_error:.3g} rad",
            f"  iterations  {self.iterations} in {1e3 * self.seconds:.3g} ms",
            f"  condition   {self.condition:.3g}",
        ]
        if self.evaluations:
            lines.append(f"  evaluations {self.evaluations} of numeric criteria")
        if self.escapes:
            lines.append(f"  escapes     {self.escapes} from a saddle point, along negative curvature")
        if self.restarts:
            lines.append(f"  restarts    {self.restarts} from other configurations")
        if self.alternatives:
            lines.append(f"  alternatives {len(self.alternatives)} more, the best first")
        if self.criteria:
            terms = ", ".join(f"{name} {value:.4g}" for name, value in self.criteria.items())
            lines.append(f"  H           {self.cost:.6g} ({terms}); null-space residual {self.null_space_residual:.2g}")
        if self.status is Status.COMPROMISE:
            multiplier, error = np.linalg.norm(self.multipliers), np.linalg.norm(self.report.residual)
            lines.append(
                f"  multiplier  {multiplier:.3g} of the task in H; error / multiplier {error / multiplier:.3g}"
            )
        if self.status.depends_on_start and not self.restarts:
            lines.append(f"  try         {TRY}")
        if self.active_limits:
            lines.append(f"  at limit    {', '.join(self.active_limits)}")
        if self.active_clearances:
            lines.append(f"  close       {', '.join(self.active_clearances)}")
        if self.relaxed:
            lines.append(f"  relaxed     {', '.join(map(str, self.relaxed))}")
        if self.unused:
            lines.append(f"  not used    {self.unused}")
        return "\n".join(lines)


@dataclass(frozen=True)
class ComputedReport:
    """The ``inspect`` of a Solution that was pickled: a report that is already computed.

    Attributes:
        report: the report.
    """

    report: Report

    def __call__(self) -> Report:
        """The report."""
        return self.report
