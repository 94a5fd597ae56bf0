"""Numeric criteria: H(q) computed by Python, of any library, with a gradient that is given or by differences."""

from __future__ import annotations

import weakref
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jtik.criterion.function_criterion import FunctionCriterion
from jtik.criterion.numeric_function import NumericFunction
from jtik.criterion.tracing import CriterionError
from jtik.robot import Kinematics, Robot
from jtik.symbolic import SX, Expression, vec, vertcat
from jtik.types import Array

DIFFERENCE_STEP = 6e-6
"""Step of central differences [rad] or [m]: the cube root of the rounding error, where it and the third derivative
contribute about equally to the error of a gradient of order 1."""


DIRECTIONAL_STEP = 1e-5
"""Length of the displacement [rad] or [m] over which a given gradient is compared with the function."""


class NumericCriterion(FunctionCriterion):
    """A function of numbers as a criterion; made by ``@jtik.criterion(numeric=True)``.

    ``f(q, *, parameter=...)`` gets q (nq,) of the solver's robot and its live parameters as numbers, and returns H. It
    must be smooth, without an internal state, and quick: each step calls it once or twice for H and, without a
    ``gradient``, 2 n times for the gradient; the second derivatives of "second_order", and of the check at the end of
    a solve that H is minimal, call the gradient 2 n times. `jtik.Solution.evaluations` says how often. Values at the
    last configurations are kept and not computed again.

    It works with every strategy, not with ``compiled=True``. It is pickled by its name, as every function, and so are
    its solvers. Where it raises an error in a solve, the solve ends as NOT_FINITE, and `failure` returns the error.

    Args:
        function: the function.
        name: name of the criterion.
        defaults: first values of the parameters by name.
        gradient: a function with the same arguments that returns dH/dv (n,), or None for central differences.
        step: step of the differences [rad] or [m].
    """

    def __init__(
        self,
        function: Callable[..., Any],
        name: str,
        defaults: Mapping[str, ArrayLike],
        gradient: Callable[..., Any] | None = None,
        step: float = DIFFERENCE_STEP,
    ) -> None:
        super().__init__(function, name, defaults)
        self._gradient_function, self._step = gradient, step
        self._functions: weakref.WeakKeyDictionary[Robot, NumericFunction] = weakref.WeakKeyDictionary()

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name != "_functions"}

    def __setstate__(self, state: Mapping[str, Any]) -> None:
        self.__dict__.update(state)
        self._functions = weakref.WeakKeyDictionary()

    def beginning_at(self, defaults: Mapping[str, ArrayLike]) -> NumericCriterion:
        """The same criterion with other first values of its parameters.

        Args:
            defaults: first values of the parameters by name.
        """
        return NumericCriterion(self._function, self.name, defaults, self._gradient_function, self._step)

    def value(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> Expression:
        """A call of the function, as an expression."""
        column = vertcat(*[vec(parameters[name]) for name in self._defaults]) if self._defaults else SX(0, 1)
        return self.on(kinematics.robot).symbolic(kinematics.q, column)

    def on(self, robot: Robot) -> NumericFunction:
        """The function on a robot, which counts its evaluations there.

        Args:
            robot: the robot.
        """
        found = self._functions.get(robot)
        if found is None:
            shapes = {name: np.shape(value) for name, value in self._defaults.items()}
            found = NumericFunction(self.name, robot, self._function, self._gradient_function, self._step, shapes)
            self._functions[robot] = found
        return found

    def failure(self, robot: Robot) -> Exception | None:
        """The last error of the function or of its gradient on a robot, such as ``ik.robot``; None without one.

        Args:
            robot: the robot of the solver.
        """
        return self.on(robot).failure

    def check(self, robot: Robot, q: Array, column: Array) -> None:
        """Compute H and its gradient at q.

        Args:
            robot: the robot.
            q: configuration (nq,) [rad] or [m].
            column: values of its parameters in one vector, matrices columns first.

        Raises:
            CriterionError: when one of them raises an error or is not numeric, or when the gradient is not that of H.
        """
        function = self.on(robot)
        function.failure = None
        function.guarded(lambda: np.array(function.value(q, column)), ())
        if function.failure is None:
            function.guarded(lambda: function.gradient(q, column), (robot.n,))
        if function.failure is not None:
            raise function.failure
        if self._gradient_function is not None:
            self._check_gradient(robot, q, column)

    def _check_gradient(self, robot: Robot, q: Array, column: Array) -> None:
        """Raise CriterionError when the given gradient is not the derivative of the function along one direction."""
        function = self.on(robot)
        direction: Array = np.random.default_rng(0).standard_normal(robot.n)
        step = DIRECTIONAL_STEP / float(np.linalg.norm(direction))

        def value(share: float) -> float:
            at: Array = np.asarray(robot.integrate(q, share * step * direction))
            return float(function.guarded(lambda: np.array(function.value(at, column)), ()))

        after, middle, before = value(1.0), value(0.0), value(-1.0)
        function.failure = None  # a value beside q does not have to exist
        derivative, given = (after - before) / (2 * step), float(function.gradient(q, column) @ direction)
        change = abs(after - 2 * middle + before) / step  # by this much the derivatives on both sides differ
        allowed = 1e-2 * max(abs(derivative), abs(given)) + change + 1e-9 * max(abs(middle), 1.0) / step
        if np.isfinite([derivative, given]).all() and abs(derivative - given) > allowed:
            raise CriterionError(
                self.name,
                f"its gradient says that H changes by {given:.6g} along v = {np.round(direction, 3).tolist()} at q = "
                f"{q.tolist()}, and the function by {derivative:.6g}; expected dH/dv of the same function",
            )
