"""Criteria in residual form, H = 1/2 |r(q)|^2, whose Gauss-Newton Hessian needs first derivatives only."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass

from jtik.criterion.base import Criterion
from jtik.criterion.tracing import as_column
from jtik.robot import Kinematics
from jtik.symbolic import Expression, Function, gram, jacobian, sumsqr


class ResidualCriterion(Criterion):
    """H = 1/2 |r|^2 of a vector r(q), such as distances from where points should be.

    Prefer it to `Criterion` where H is a sum of squares that can become small. A strategy that takes second derivatives
    of H, such as "hybrid+second_order", then uses the Gauss-Newton Hessian A' A with A = dr/dv. It needs less
    computation than the Hessian of H, and has no direction of negative curvature.

    Source: Nocedal and Wright, *Numerical Optimization*, 2006, section 10.3.
    """

    @abstractmethod
    def residual(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> Expression:
        """r at ``kinematics.q``: a column, a row or a list of scalar expressions; unit: the square root of that of H.

        The parameters have the shapes of their first values.

        Args:
            kinematics: the robot at a symbolic configuration.
            parameters: expressions of the live parameters by name.
        """

    def value(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> Expression:
        """1/2 |r|^2."""
        return sumsqr(as_column(self.name, self.residual(kinematics, parameters))) / 2


@dataclass(frozen=True)
class LeastSquares:
    """The criteria of one solver, divided into those in residual form and the others.

    Attributes:
        residuals: (q, parameters) -> all residuals (k, 1), and for each row the weight of its criterion (k, 1).
        others: (q, parameters) -> the weighted sum of the criteria that are not in residual form.
    """

    residuals: Function
    others: Function

    def hessian(self, q: Expression, v: Expression, parameters: Expression) -> Expression:
        """The Gauss-Newton Hessian A' diag(w) A of the criteria in residual form, A = dr/dv, (n, n).

        Args:
            q: configuration (nq, 1) as an expression of v.
            v: symbols of the velocity (n, 1).
            parameters: live parameters.
        """
        r, weights = self.residuals(q, parameters)
        return gram(jacobian(r, v), weights)
