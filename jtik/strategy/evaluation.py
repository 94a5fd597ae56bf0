"""Task and criterion evaluated at one configuration."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from jtik.symbolic import Expression, norm, sumsqr


@dataclass(frozen=True)
class Evaluation:
    """Task and criterion at one configuration, without derivatives.

    Attributes:
        q: configuration (nq, 1).
        residual: r = L' e with Kp = L L', (m, 1).
        H: weighted sum of the criteria; 0 without any.
        dq: the displacement that led here (n, 1); None for the configuration that a step starts from.
    """

    q: Expression
    residual: Expression
    H: Expression
    dq: Expression = None

    @cached_property
    def V(self) -> Expression:
        """The Lyapunov function of the task, 1/2 e' Kp e = 1/2 |r|^2."""
        return sumsqr(self.residual) / 2

    @cached_property
    def length(self) -> Expression:
        """|r| = sqrt(2 V)."""
        return norm(self.residual)
