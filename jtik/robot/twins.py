"""The same kinematics for numbers and for symbols: one formula, compiled where numbers ask for it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import numpy as np

from jtik.errors import ArgumentError, finite_array
from jtik.symbolic import SX, Expression, Function, function, is_symbolic, symbol, vertcat

if TYPE_CHECKING:
    from jtik.robot.model import Robot

FrameQuantity: TypeAlias = Literal["pose", "position", "jacobian", "center_of_mass"]
LayoutQuantity: TypeAlias = Literal["tangent", "integrate", "difference"]

_ARGUMENTS: dict[LayoutQuantity, tuple[str, ...]] = {
    "tangent": ("q",),
    "integrate": ("q", "dq"),
    "difference": ("start", "end"),
}
_VECTORS = ("position", "center_of_mass", "integrate", "difference")


class Twins:
    """Answers for one robot: SX gives expressions, MX a call of the compiled function, numbers an array."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._compiled: dict[tuple[str, str | None], Function] = {}

    def of_frame(self, quantity: FrameQuantity, q: Expression, frame: str | None) -> Any:
        """The pose, position or Jacobian of a frame."""
        frame = self._robot.frame(frame)
        if isinstance(q, SX):
            return getattr(self._robot.at(q), quantity)(frame)
        value = q if is_symbolic(q) else finite_array("q", q, (self._robot.nq,))
        if not is_symbolic(q):
            self._check_quaternions("q", value)
        key = (quantity, frame)
        if key not in self._compiled:
            symbolic_q = symbol("q", self._robot.nq)
            result = getattr(self._robot.at(symbolic_q), quantity)(frame)
            self._compiled[key] = function(quantity, [symbolic_q], [result], ["q"], [quantity])
        return _answer(self._compiled[key], [value])

    def of_layout(self, quantity: LayoutQuantity, *values: Expression) -> Any:
        """The tangent map, a step, or the displacement between two configurations."""
        names = _ARGUMENTS[quantity]
        checked = [self.checked(name, value) for name, value in zip(names, values, strict=True)]
        key = (quantity, None)
        if key not in self._compiled:
            inputs = [symbol(name, self._size(name)) for name in names]
            self._compiled[key] = function(quantity, inputs, [self._build(quantity, *inputs)], names, [quantity])
        if any(isinstance(value, SX) for value in checked):
            return self._build(quantity, *[SX(value) for value in checked])
        return _answer(self._compiled[key], checked)

    def _build(self, quantity: LayoutQuantity, *values: Expression) -> Expression:
        joints = self._robot.independent_joints
        places = [(joint, self._robot.q_slice(joint.name), self._robot.v_slice(joint.name)) for joint in joints]
        if quantity == "tangent":
            (q,) = values
            total = SX(self._robot.nq, self._robot.n)
            for joint, at_q, at_v in places:
                total[at_q, at_v] = joint.type.tangent(q[at_q])
            return total
        first, second = values
        if quantity == "integrate":
            return vertcat(*[j.type.integrate(first[at_q], second[at_v]) for j, at_q, at_v in places])
        return vertcat(*[j.type.difference(first[at_q], second[at_q]) for j, at_q, _ in places])

    def _size(self, argument: str) -> int:
        return self._robot.n if argument == "dq" else self._robot.nq

    def checked(self, argument: str, value: Expression) -> Expression:
        """The argument as an array or an expression of the right shape; raises ArgumentError for anything else."""
        size = self._size(argument)
        if not is_symbolic(value):
            array = finite_array(argument, value, (size,))
            if argument != "dq":
                self._check_quaternions(argument, array)
            return array
        if value.shape != (size, 1):
            raise ArgumentError(argument, f"an expression of shape {value.shape}", f"shape ({size}, 1)")
        return value

    def _check_quaternions(self, argument: str, q: Any) -> None:
        for joint in self._robot.independent_joints:
            start = joint.type.quaternion_start
            if start is not None and not q[self._robot.q_slice(joint.name)][start:].any():
                given = f"a zero quaternion for joint {joint.name!r}"
                raise ArgumentError(argument, given, "quaternions (w, x, y, z) other than zero")


def _answer(compiled: Function, values: list[Expression]) -> Any:
    result = compiled(*values)
    if is_symbolic(result):
        return result
    array = np.array(result.full())
    return array[:, 0] if compiled.name_out(0) in _VECTORS else array
