"""Numeric and symbolic evaluation of the same kinematics: one formula, compiled when first evaluated with numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import numpy as np

from jtik.arguments import finite_array
from jtik.errors import ArgumentError
from jtik.robot.row_indexing import by_rows
from jtik.symbolic import SX, Expression, Function, function, is_symbolic, symbol, vertcat

if TYPE_CHECKING:
    from jtik.robot.model import Robot

FrameQuantity: TypeAlias = Literal[
    "pose", "position", "jacobian", "center_of_mass", "first_moment_jacobian", "mass_matrix"
]
LayoutQuantity: TypeAlias = Literal["tangent", "integrate", "difference"]

_ARGUMENTS: dict[LayoutQuantity, tuple[str, ...]] = {
    "tangent": ("q",),
    "integrate": ("q", "dq"),
    "difference": ("start", "end"),
}
_VECTORS = ("position", "center_of_mass", "integrate", "difference")
_READ_BY_ROWS = ("pose", "jacobian")


class Evaluator:
    """Evaluates the kinematics of one robot.

    An SX gives expressions, an MX a call of the compiled function, numbers an array. Symbolic poses and Jacobians are
    read by rows, see `jtik.robot.row_indexing`.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._compiled: dict[tuple[str, str | None], Function] = {}

    def of_frame(self, quantity: FrameQuantity, q: Expression, frame: str | None) -> Any:
        """The pose, position or Jacobian of a frame."""
        frame = self._robot.frame(frame)
        if isinstance(q, SX):
            return getattr(self._robot.at(q), quantity)(frame)
        value = q if is_symbolic(q) else self._robot.configuration(q)
        key = (quantity, frame)
        if key not in self._compiled:
            symbolic_q = symbol("q", self._robot.nq)
            result = getattr(self._robot.at(symbolic_q), quantity)(frame)
            self._compiled[key] = function(quantity, [symbolic_q], [result], ["q"], [quantity])
        return _result(self._compiled[key], [value])

    def of_layout(self, quantity: LayoutQuantity, *values: Expression) -> Any:
        """The tangent map, the configuration after a displacement, or the displacement between two configurations."""
        names = _ARGUMENTS[quantity]
        checked = [self._checked(name, value) for name, value in zip(names, values, strict=True)]
        key = (quantity, None)
        if key not in self._compiled:
            inputs = [symbol(name, self._size(name)) for name in names]
            self._compiled[key] = function(quantity, inputs, [self._build(quantity, *inputs)], names, [quantity])
        if any(isinstance(value, SX) for value in checked):
            return self._build(quantity, *[SX(value) for value in checked])
        return _result(self._compiled[key], checked)

    def _build(self, quantity: LayoutQuantity, *values: Expression) -> Expression:
        joints = self._robot.independent_joints
        slices = [(joint, self._robot.q_slice(joint.name), self._robot.v_slice(joint.name)) for joint in joints]
        if quantity == "tangent":
            (q,) = values
            total = SX(self._robot.nq, self._robot.n)
            for joint, at_q, at_v in slices:
                total[at_q, at_v] = joint.type.tangent(q[at_q])
            return total
        first, second = values
        if quantity == "integrate":
            return vertcat(*[j.type.integrate(first[at_q], second[at_v]) for j, at_q, at_v in slices])
        return vertcat(*[j.type.difference(first[at_q], second[at_q]) for j, at_q, _ in slices])

    def _size(self, argument: str) -> int:
        return self._robot.n if argument == "dq" else self._robot.nq

    def _checked(self, argument: str, value: Expression) -> Expression:
        """The argument as an array or an expression of the right shape; raises ArgumentError for anything else."""
        size = self._size(argument)
        if not is_symbolic(value):
            if argument == "dq":
                return finite_array(argument, value, (size,))
            return self._robot.configuration(value, argument=argument)
        if value.shape != (size, 1):
            raise ArgumentError(argument, f"an expression of shape {value.shape}", f"shape ({size}, 1)")
        return value


def _result(compiled: Function, values: list[Expression]) -> Any:
    result, quantity = compiled(*values), compiled.name_out(0)
    if is_symbolic(result):
        return by_rows(result) if quantity in _READ_BY_ROWS else result
    array = np.array(result.full())
    return array[:, 0] if quantity in _VECTORS else array
