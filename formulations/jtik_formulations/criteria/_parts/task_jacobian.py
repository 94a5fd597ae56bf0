"""Base of the criteria on the Jacobian of task rows, with lengths scaled, and its damped factors."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar, cast, get_args

import numpy as np
from numpy.typing import ArrayLike

from jtik import Criterion, FrameTask
from jtik.arguments import choice, positive_number
from jtik.arguments import name as read_name
from jtik.criterion.short_repr import call_text
from jtik.robot import Kinematics, Robot
from jtik.symbolic import Expression, dot, fmax, horzcat, identity, sumsqr, vertcat
from jtik.task.targets import Kind
from jtik.task.weighted import Axes, kept, named
from jtik_formulations.criteria._parts.scalars import frame_or_tip

DAMPING = 1e-3
"""Default of the damping: small against the singular values of common arms, large against rounding."""

SMALLEST_DAMPING = 1e-9
"""Smallest damping that is used: its 16th power is a normal number, and sums of squares resolve it beside 1."""

SMALLEST_LENGTH = 1e-9
"""Smallest characteristic length [m] that is divided by."""


class TaskJacobianCriterion(Criterion):
    """Base: H is a function of the Jacobian J (m, n) of rows of a frame, its linear rows divided by a length.

    Args:
        frame: name of the frame, or a `jtik.FrameTask`, whose frame, kind and axes are taken; the tip when None.
        kind: "position", "orientation" or "pose".
        axes: names of the rows to keep, as those of a `jtik.FrameTask`; None keeps all.
        length: characteristic length [m]. By default 1 m where all rows are of one unit; else the length at which
            linear and angular rows have the same mean square in the robot's home configuration.
        damping: epsilon in J J' + epsilon^2 I, positive, in the unit of J.
        name: the first part of the names of its parameters.

    Raises:
        ArgumentError: when an argument is out of range or a row is unknown.
        UnknownNameError: when the robot has no such frame.
    """

    non_negative_parameters = ("damping", "length")

    axes_matter: ClassVar[bool] = False
    """Whether H depends on the axes of three orientation rows."""

    def __init__(
        self,
        frame: str | FrameTask | None,
        kind: Kind,
        axes: Axes,
        length: float | None,
        damping: float,
        name: str,
    ) -> None:
        if isinstance(frame, FrameTask):
            kind, axes = frame.kind, frame.axes
            frame = frame.frame
        self._frame, self._axes = frame_or_tip(frame), named(axes)
        self._kind: Kind = cast(Kind, choice("kind", kind, get_args(Kind)))
        self._length = None if length is None else positive_number("length", length)
        self._damping = positive_number("damping", damping)
        self.name = read_name("name", name)

    def __repr__(self) -> str:
        shown: dict[str, object] = {"frame": self._frame, "kind": self._kind, "axes": self._axes}
        shown |= {"length": self._length, "damping": self._damping, **self.options()}
        shown = {key: value for key, value in shown.items() if value is not None}
        if self._damping == DAMPING:
            del shown["damping"]
        if self.name != type(self).name:
            shown["name"] = self.name
        return call_text(type(self).__name__, **shown)

    def options(self) -> Mapping[str, object]:
        """What the repr shows besides the rows."""
        return {}

    def parameters(self, robot: Robot) -> Mapping[str, ArrayLike]:
        """The damping, and where there are linear rows the characteristic length."""
        linear = self._linear(robot)
        if not any(linear):
            return {"damping": self._damping}
        return {"damping": self._damping, "length": self._length or self._common_length(robot, linear)}

    def jacobian(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> Expression:
        """J (m, n), its linear rows divided by the length: base axes for lengths, the frame's axes for angles."""
        robot = kinematics.robot
        J, dimension = kinematics.plain_jacobian(self._frame), robot.dimension
        linear, angular = J[:dimension, :], J[5:, :] if dimension == 2 else J[3:, :]
        if dimension == 3 and self._kind != "position" and (self.axes_matter or self._axes is not None):
            angular = kinematics.rotation(self._frame).T @ angular
        if "length" in parameters:
            linear = linear / fmax(parameters["length"], SMALLEST_LENGTH)
        parts = {"position": (linear,), "orientation": (angular,), "pose": (linear, angular)}[self._kind]
        rows = vertcat(*parts)
        return vertcat(*[rows[i, :] for i in self._rows(robot)])

    def factors(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> DampedFactors:
        """The factors of J J' + epsilon^2 I."""
        return DampedFactors(self.jacobian(kinematics, parameters), parameters["damping"])

    def row_count(self, robot: Robot) -> int:
        """m, the number of rows on this robot."""
        return len(self._rows(robot))

    def _names(self, robot: Robot) -> list[str]:
        position = [*"xyz"[: robot.dimension]]
        orientation = ["rz"] if robot.dimension == 2 else ["rx", "ry", "rz"]
        return {"position": position, "orientation": orientation, "pose": position + orientation}[self._kind]

    def _rows(self, robot: Robot) -> list[int]:
        return kept(self._axes, self._names(robot), f" for kind {self._kind!r}")

    def _linear(self, robot: Robot) -> list[bool]:
        names = self._names(robot)
        return [len(names[i]) == 1 for i in self._rows(robot)]

    def _common_length(self, robot: Robot, linear: list[bool]) -> float:
        """1 m, or for rows of both units the length at which they have the same mean square at home."""
        if all(linear):
            return 1.0
        J = robot.jacobian(robot.home, self._frame)
        squares = [float(np.mean(np.sum(J[rows] ** 2, axis=1))) for rows in (slice(0, robot.dimension), slice(3, 6))]
        if robot.dimension == 2:
            squares[1] *= 3  # two of the three angular rows are zero
        return float(np.sqrt(squares[0] / squares[1])) if min(squares) > 0 else 1.0


class DampedFactors:
    """A = J J' + epsilon^2 I = L D L', by orthogonal rows of [J, epsilon I], which are never dependent.

    The pivots D are sums of squares: rounding cannot make them negative, as it can those of a factorised A.

    Args:
        J: the matrix (m, n).
        damping: epsilon; at least 1e-9 is used.

    Attributes:
        pivots: D_i, m scalars; each is at least epsilon^2.
        inverse_rows: the rows of L^-1, m columns (m, 1).
        trace: the sum of the eigenvalues of A.
    """

    def __init__(self, J: Expression, damping: Expression) -> None:
        m, n = J.shape
        epsilon = fmax(damping, SMALLEST_DAMPING)
        augmented = horzcat(J, epsilon * identity(m))
        self.pivots: list[Expression] = []
        self.inverse_rows: list[Expression] = []
        basis: list[Expression] = []
        for i in range(m):
            row = augmented[i, :].T
            for other, pivot in zip(basis, self.pivots, strict=True):
                row = row - (dot(other, row) / pivot) * other
            basis.append(row)
            self.pivots.append(sumsqr(row))
            self.inverse_rows.append(row[n:] / epsilon)
        self.trace: Expression = sum(sumsqr(J[i, :].T) for i in range(m)) + m * epsilon**2

    @property
    def determinant(self) -> Expression:
        """det A, the product of the pivots."""
        product: Expression = 1
        for pivot in self.pivots:
            product = product * pivot
        return product

    @property
    def inverse_trace(self) -> Expression:
        """The sum of the reciprocal eigenvalues of A."""
        return sum(sumsqr(row) / pivot for row, pivot in zip(self.inverse_rows, self.pivots, strict=True))

    def inverse_form(self, u: Expression) -> Expression:
        """u' A^-1 u."""
        rows = zip(self.inverse_rows, self.pivots, strict=True)
        return sum(dot(row, u) ** 2 / pivot for row, pivot in rows)
