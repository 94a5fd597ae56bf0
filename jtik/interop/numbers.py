"""A criterion as numbers: H, its gradient and its Hessian at a configuration, for libraries that want arrays."""

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
"""The quadratic part of an objective made of a criterion: the identity, or the Hessian without its negative part."""


class CriterionNumbers:
    """H(q) and its derivatives with respect to the velocity, compiled once.

    Args:
        criteria: a criterion or a weighted sum.
        robot: the robot.

    Attributes:
        parameters: live parameters by name, as those of `jtik.InverseKinematics`.
    """

    def __init__(self, criteria: Criterion | CriterionSum, robot: Robot) -> None:
        self.robot = robot
        self._terms = CriterionTerms.of(robot, criteria)
        self.parameters: Parameters = self._terms.parameters
        q, parameters = self._symbols()
        H = self._value(q, parameters)
        slope = robot.tangent(q).T @ gradient(H, q)
        self._evaluate = CompiledFunction(function("criterion", [q, parameters], [H, slope]))

    def value(self, q: Array) -> float:
        """H."""
        return float(self._evaluate(q, self.parameters.memory)[0][0, 0])

    def gradient(self, q: Array) -> Array:
        """dH/dv, (n,)."""
        slope: Array = self._evaluate(q, self.parameters.memory)[1][:, 0]
        return slope

    def hessian(self, q: Array) -> Array:
        """d2H/dv2 along ``robot.integrate``, (n, n)."""
        bend: Array = self._bend(q, self.parameters.memory)[0]
        return bend

    def objective(self, q: Array, gain: float, curvature: Curvature) -> tuple[Array, Array]:
        """(P, c) of the step 1/2 dq'P dq + c'dq that goes down H: (I, gain dH) or gain (Hessian made convex, dH)."""
        c = gain * self.gradient(q)
        return (np.eye(len(c)) if curvature == "identity" else gain * convex(self.hessian(q))), c

    @cached_property
    def _bend(self) -> CompiledFunction:
        q, parameters = self._symbols()
        v = symbol("v", self.robot.n)
        moved = self._value(self.robot.integrate(q, v), parameters)
        bend = jacobian(gradient(moved, v), v)
        return CompiledFunction(function("hessian", [q, parameters], [substitute(bend, v, zeros(self.robot.n))]))

    def _symbols(self) -> tuple[Expression, Expression]:
        return symbol("q", self.robot.nq), self.parameters.symbols()

    def _value(self, q: Expression, parameters: Expression) -> Expression:
        at = symbol("at", self.robot.nq)
        H = sum(self._terms.values(self.robot.at(at), parameters), zeros(1))
        return substitute(H, at, q)


def convex(hessian: Array) -> Array:
    """The nearest positive semidefinite matrix: negative eigenvalues become zero."""
    values, vectors = np.linalg.eigh((hessian + hessian.T) / 2)
    nearest: Array = (vectors * np.maximum(values, 0.0)) @ vectors.T
    return nearest


def checked(gain: float, curvature: str) -> None:
    """Raise ArgumentError for a gain that is not positive, or a curvature there is not."""
    if not 0 < gain < np.inf:
        raise ArgumentError("gain", gain, "a positive number")
    if curvature not in ("identity", "convex"):
        raise ArgumentError("curvature", curvature, "'identity' or 'convex'")
