"""Task and criterion evaluated at one configuration."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from jtik.symbolic import Expression, dot, norm, sumsqr


@dataclass(frozen=True)
class Evaluation:
    """Task and criterion at one configuration, without derivatives.

    Attributes:
        q: configuration (nq, 1).
        residual: r = L' e with Kp = L L', (m, 1), to a nearer target where the target is distant.
        H: weighted sum of the criteria; 0 without any.
        dq: the displacement that led here (n, 1); None for the configuration that a step starts from.
        unshifted: the residual for the target with zeros where its numbers only shift the residual (m, 1): it changes
            as the residual does, without the rounding errors of a distant target; None for the residual itself.
        whole: the residual to the target itself (m, 1); None where that is ``residual``.
    """

    q: Expression
    residual: Expression
    H: Expression
    dq: Expression = None
    unshifted: Expression = None
    whole: Expression = None

    @cached_property
    def V(self) -> Expression:
        """The Lyapunov function of the task, 1/2 e' Kp e = 1/2 |r|^2."""
        return sumsqr(self.residual) / 2

    @cached_property
    def length(self) -> Expression:
        """The norm of the residual to the target itself, sqrt(2 V) where it is not distant."""
        return norm(self.to_target)

    @cached_property
    def to_target(self) -> Expression:
        """The residual to the target itself, however distant (m, 1)."""
        return self.residual if self.whole is None else self.whole

    @cached_property
    def V_to_target(self) -> Expression:
        """V of the residual to the target itself."""
        return self.V if self.whole is None else sumsqr(self.whole) / 2

    def change(self, after: Evaluation) -> Expression:
        """The change of the residual from here to ``after`` (m, 1).

        Args:
            after: the evaluation after a displacement.
        """
        if self.unshifted is None or after.unshifted is None:
            return after.residual - self.residual
        return after.unshifted - self.unshifted

    def decrease(self, after: Evaluation) -> Expression:
        """V here less V at ``after``, accurate also where V is so large that its own rounding exceeds the decrease.

        Args:
            after: the evaluation after a displacement.
        """
        change = self.change(after)
        return -dot(change, self.residual + change / 2)
