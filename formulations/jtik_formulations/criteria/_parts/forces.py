"""The gradient of a function of points of a robot."""

from __future__ import annotations

from dataclasses import dataclass, field

from jtik.symbolic import Expression, dot, gradient, substitute, symbol, vertcat


@dataclass
class Forces:
    """Derivatives of H with respect to points of a robot.

    Attributes:
        points: the points (d, 1) [m].
        forces: the derivative with respect to each of them (d, 1).
    """

    points: list[Expression] = field(default_factory=list)
    forces: list[Expression] = field(default_factory=list)

    def add(self, point: Expression, force: Expression) -> None:
        """Add what a point contributes."""
        self.points.append(point)
        self.forces.append(force)

    def gradient(self, q: Expression) -> Expression:
        """dH/dq (nq, 1): one sweep along the robot from its tips to its base."""
        forces = vertcat(*self.forces)
        constant = symbol("forces", forces.shape[0])
        return substitute(gradient(dot(constant, vertcat(*self.points)), q), constant, forces)
