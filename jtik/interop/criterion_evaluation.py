"""Numeric evaluation of a criterion: H, its gradient and its Hessian as arrays, for other libraries."""

from __future__ import annotations

from functools import cached_property
from typing import Literal

import numpy as np

from jtik.criterion import Criterion, CriterionSum, CriterionTerms, Parameters
from jtik.errors import ArgumentError
from jtik.robot import Robot
from jtik.symbolic import Expression, function, gradient, jacobian, substitute, symbol, zeros
from jtik.symbolic.compile import CompiledFunction
from jtik.types import Array

Curvature = Literal["identity", "convex"]
"""The quadratic part of the objective of a criterion: the identity, or the Hessian without its negative part."""


class CriterionNumbers:
    """H(q) and its derivatives with respect to the velocity, compiled once.

    Args:
        criteria: a criterion or a weighted sum.
        robot: the robot.

    Attributes:
        robot: the robot.
        parameters: live parameters by name, as those of `jtik.InverseKinematics`.
    """

    def __init__(self, criteria: Criterion | CriterionSum, robot: Robot) -> None:
        self.robot = robot
        self._terms = CriterionTerms.of(robot, criteria)
        self.parameters: Parameters = self._terms.parameters
        q, parameters = self._symbols()
        H = self._value(q, parameters)
        dH = robot.tangent(q).T @ gradient(H, q)
        self._evaluate = CompiledFunction(function("criterion", [q, parameters], [H, dH]))

    def value(self, q: Array) -> float:
        """H at q (nq,).

        Args:
            q: configuration (nq,) [rad] or [m].
        """
        return float(self._evaluate(q, self.parameters.memory)[0][0, 0])

    def gradient(self, q: Array) -> Array:
        """dH/dv at q (nq,), (n,).

        Args:
            q: configuration (nq,) [rad] or [m].
        """
        dH: Array = self._evaluate(q, self.parameters.memory)[1][:, 0]
        return dH

    def hessian(self, q: Array) -> Array:
        """d2H/dv2 along ``robot.integrate`` at q (nq,), (n, n).

        Args:
            q: configuration (nq,) [rad] or [m].
        """
        hessian: Array = self._hessian(q, self.parameters.memory)[0]
        return hessian

    def objective(self, q: Array, gain: float, curvature: Curvature) -> tuple[Array, Array]:
        """(P, c) of the objective 1/2 dq'P dq + c'dq that lowers H: (I, gain dH) or gain (convex Hessian, dH).

        Args:
            q: configuration (nq,) [rad] or [m].
            gain: factor of the gradient, positive.
            curvature: "identity" or "convex", the choice of P.
        """
        c = gain * self.gradient(q)
        return (np.eye(len(c)) if curvature == "identity" else gain * convex(self.hessian(q))), c

    @cached_property
    def _hessian(self) -> CompiledFunction:
        q, parameters = self._symbols()
        v = symbol("v", self.robot.n)
        moved = self._value(self.robot.integrate(q, v), parameters)
        hessian = jacobian(gradient(moved, v), v)
        return CompiledFunction(function("hessian", [q, parameters], [substitute(hessian, v, zeros(self.robot.n))]))

    def _symbols(self) -> tuple[Expression, Expression]:
        return symbol("q", self.robot.nq), self.parameters.symbols()

    def _value(self, q: Expression, parameters: Expression) -> Expression:
        at = symbol("at", self.robot.nq)
        H = sum(self._terms.values(self.robot.at(at), parameters), zeros(1))
        return substitute(H, at, q)


def convex(hessian: Array) -> Array:
    """The closest positive semidefinite matrix: negative eigenvalues become zero.

    Args:
        hessian: the matrix (n, n); its symmetric part counts.
    """
    values, vectors = np.linalg.eigh((hessian + hessian.T) / 2)
    closest: Array = (vectors * np.maximum(values, 0.0)) @ vectors.T
    return closest


def checked(gain: float, curvature: str) -> None:
    """Check the options of an objective.

    Args:
        gain: factor of the gradient.
        curvature: the choice of P.

    Raises:
        ArgumentError: for a gain that is not positive and finite, or a curvature other than "identity" and "convex".
    """
    if not 0 < gain < np.inf:
        raise ArgumentError("gain", gain, "a positive number")
    if curvature not in ("identity", "convex"):
        raise ArgumentError("curvature", curvature, "'identity' or 'convex'")
