"""A numeric function H(q, parameters) as a function of CasADi, with derivatives that are given or by differences."""

from __future__ import annotations

import weakref
from collections import OrderedDict
from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

import numpy as np

from jtik.criterion.tracing import CriterionError, short
from jtik.robot import Robot
from jtik.symbolic import Callback, Sparsity
from jtik.types import Array

KEPT = 16
"""Number of configurations whose values and gradients are kept: a step asks for those where the last one ended."""

SECOND_STEP = 1e-4
"""Step of the differences of a gradient that is itself by differences [rad] or [m]."""

Parameters: TypeAlias = Mapping[str, Any]


class NumericFunction:
    """H and its derivatives at numbers, counted, and kept for the last configurations.

    Args:
        name: name of the criterion.
        robot: the robot.
        function: (q, parameters) -> H.
        gradient: (q, parameters) -> dH/dv; None for differences.
        step: step of the differences [rad] or [m].
        shapes: shapes of the parameters, in the order of their column.

    Attributes:
        evaluations: how often ``function`` was called.
        gradients: how often ``gradient`` was called.
        failure: the last error of either, for the error message; None without one.
        interruption: what ended either that is no error, such as KeyboardInterrupt, until it is raised.
    """

    def __init__(
        self,
        name: str,
        robot: Robot,
        function: Callable[..., Any],
        gradient: Callable[..., Any] | None,
        step: float,
        shapes: Mapping[str, tuple[int, ...]],
    ) -> None:
        self.name, self._function, self._gradient, self._step = name, function, gradient, step
        self._robot, self._shapes = weakref.ref(robot), dict(shapes)
        self.evaluations = self.gradients = 0
        self.failure: CriterionError | None = None
        self.interruption: BaseException | None = None
        self._values: OrderedDict[bytes, float] = OrderedDict()
        self._gradients: OrderedDict[bytes, Array] = OrderedDict()
        size = sum(int(np.prod(shape)) for shape in self._shapes.values())
        self.symbolic = _Value(self, robot.nq, size)

    def value(self, q: Array, column: Array) -> float:
        """H at q (nq,)."""
        key = q.tobytes() + column.tobytes()
        found = self._values.get(key)
        if found is None:
            self.evaluations += 1
            found = self._number(self._function(q.copy(), **self._named(column)), q)
            _keep(self._values, key, found)
        return found

    def gradient(self, q: Array, column: Array) -> Array:
        """dH/dv at q, (n,)."""
        key = q.tobytes() + column.tobytes()
        found = self._gradients.get(key)
        if found is None:
            if self._gradient is None:
                found = self._differences(lambda at: self.value(at, column), q, self._step)[0]
            else:
                self.gradients += 1
                found = self._vector(self._gradient(q.copy(), **self._named(column)), q)
            _keep(self._gradients, key, found)
        return found

    def hessian(self, q: Array, column: Array) -> Array:
        """d2H/dv2 at q by differences of the gradient, symmetric, (n, n)."""
        step = self._step if self._gradient is not None else max(self._step, SECOND_STEP)
        found = self._differences(lambda at: self.gradient(at, column), q, step)
        return (found + found.T) / 2

    def by_q(self, q: Array) -> Array:
        """(T+)': what a derivative with respect to the velocity (n, 1) is multiplied by for one by q, (nq, n)."""
        robot = self.robot
        if robot.nq == robot.n:
            return np.eye(robot.n)
        inverse: Array = np.linalg.pinv(np.array(robot.tangent(q), dtype=float))
        return inverse.T

    @property
    def robot(self) -> Robot:
        """The robot, which lives as long as a solver that uses the function."""
        robot = self._robot()
        assert robot is not None
        return robot

    def _differences(self, of: Callable[[Array], Any], q: Array, step: float) -> Array:
        """Central differences along each velocity entry, one column each, (k, n)."""
        robot, columns = self.robot, []
        for unit in np.eye(robot.n):
            ahead, behind = (np.asarray(robot.integrate(q, sign * step * unit)) for sign in (1.0, -1.0))
            after, before = np.atleast_1d(of(ahead)), np.atleast_1d(of(behind))
            with np.errstate(invalid="ignore"):  # of two infinite values
                columns.append((after - before) / (2 * step))
        return np.array(columns).T

    def _named(self, column: Array) -> dict[str, Any]:
        """The parameters by name, in their shapes; a scalar as a float."""
        named, start = dict[str, Any](), 0
        for name, shape in self._shapes.items():
            end = start + int(np.prod(shape))
            named[name] = column[start:end].reshape(shape, order="F").copy() if shape else float(column[start])
            start = end
        return named

    def _number(self, value: Any, q: Array) -> float:
        array = np.asarray(value)
        if array.dtype.kind not in "fiu" or array.size != 1:
            raise CriterionError(self.name, f"returned {short(value)} at q = {q.tolist()}; expected one number, H")
        return float(array.item())

    def _vector(self, value: Any, q: Array) -> Array:
        array = np.asarray(value)
        if array.dtype.kind not in "fiu" or array.shape != (self.robot.n,):
            given = f"shape {array.shape}" if array.dtype.kind in "fiu" else short(value)
            expected = f"dH/dv of shape ({self.robot.n},)"
            raise CriterionError(self.name, f"its gradient returned {given} at q = {q.tolist()}; expected {expected}")
        return np.array(array, dtype=float)

    def guarded(self, compute: Callable[[], Array], otherwise: tuple[int, ...]) -> Array:
        """What ``compute`` returns; NaN of the shape ``otherwise`` where it raises: the solve then ends NOT_FINITE.

        CasADi, which calls this, would make a RuntimeError of Ctrl-C. So that is kept, and raised after the call.
        """
        try:
            return compute()
        except Exception as error:
            if isinstance(error, CriterionError):
                self.failure = error
            else:
                self.failure = CriterionError(self.name, f"raised {type(error).__name__}: {error}")
                self.failure.__cause__ = error
        except BaseException as interruption:
            self.interruption = interruption
        return np.full(otherwise, np.nan)

    def raise_interruption(self) -> None:
        """Raise the KeyboardInterrupt or SystemExit that came while the function was called."""
        interruption, self.interruption = self.interruption, None
        if interruption is not None:
            raise interruption


class _Derivative(Callback):  # type: ignore[misc]
    """A function of CasADi that calls back: q, parameters, then results of the functions it is the derivative of."""

    def __init__(self, of: NumericFunction, name: str, nq: int, size: int) -> None:
        Callback.__init__(self)
        self.of, self.nq, self.size = of, nq, size
        self.after: Any = None
        # only the derivatives by q are asked for
        self.construct(name, {"is_diff_in": [True] + [False] * (self.get_n_in() - 1)})

    def get_n_in(self) -> int:
        return len(self.inputs())

    def get_n_out(self) -> int:
        return len(self.outputs())

    def get_sparsity_in(self, i: int) -> Any:
        return self.inputs()[i]

    def get_sparsity_out(self, i: int) -> Any:
        return self.outputs()[i]

    def inputs(self) -> list[Any]:
        """Sparsities of the inputs."""
        return [Sparsity.dense(self.nq, 1), Sparsity.dense(self.size, 1)]

    def outputs(self) -> list[Any]:
        """Sparsities of the outputs."""
        raise NotImplementedError

    def at(self, arguments: Any) -> tuple[Array, Array]:
        """q and the parameters as flat arrays."""
        return np.array(arguments[0].full())[:, 0], np.array(arguments[1].full()).ravel()


class _Value(_Derivative):
    """(q, parameters) -> H."""

    def __init__(self, of: NumericFunction, nq: int, size: int) -> None:
        super().__init__(of, "numeric_criterion", nq, size)

    def outputs(self) -> list[Any]:
        return [Sparsity.dense(1, 1)]

    def eval(self, arguments: Any) -> list[Any]:
        q, column = self.at(arguments)
        return [self.of.guarded(lambda: np.array([[self.of.value(q, column)]]), (1, 1))]

    def has_jacobian(self) -> bool:
        return True

    def get_jacobian(self, name: str, *_: Any) -> Any:
        self.after = _Gradient(self.of, name, self.nq, self.size)
        return self.after


class _Gradient(_Derivative):
    """(q, parameters, H) -> dH/dq (1, nq), and an empty derivative by the parameters."""

    def inputs(self) -> list[Any]:
        return [*super().inputs(), Sparsity(1, 1)]

    def outputs(self) -> list[Any]:
        return [Sparsity.dense(1, self.nq), Sparsity(1, self.size)]

    def eval(self, arguments: Any) -> list[Any]:
        q, column = self.at(arguments)
        return [
            self.of.guarded(lambda: (self.of.by_q(q) @ self.of.gradient(q, column))[None, :], (1, self.nq)),
            np.zeros((1, self.size)),
        ]

    def has_jacobian(self) -> bool:
        return True

    def get_jacobian(self, name: str, *_: Any) -> Any:
        self.after = _Hessian(self.of, name, self.nq, self.size)
        return self.after


class _Hessian(_Derivative):
    """(q, parameters, H, dH/dq, empty) -> d2H/dq2 along the motions of the robot, and empty derivatives."""

    def inputs(self) -> list[Any]:
        return [*super().inputs(), Sparsity(1, 1), Sparsity(1, self.nq), Sparsity(1, self.size)]

    def outputs(self) -> list[Any]:
        nq, size = self.nq, self.size
        return [
            *[Sparsity.dense(nq, nq), Sparsity(nq, size), Sparsity(nq, 1)],
            *[Sparsity(size, nq), Sparsity(size, size), Sparsity(size, 1)],
        ]

    def eval(self, arguments: Any) -> list[Any]:
        q, column = self.at(arguments)

        def second() -> Array:
            outer = self.of.by_q(q)
            return outer @ self.of.hessian(q, column) @ outer.T

        found = self.of.guarded(second, (self.nq, self.nq))
        return [found, *[np.zeros(each.shape) for each in self.outputs()[1:]]]


def _keep(kept: OrderedDict[bytes, Any], key: bytes, value: Any) -> None:
    """Keep the value, and forget the oldest one beyond `KEPT`."""
    kept[key] = value
    if len(kept) > KEPT:
        kept.popitem(last=False)
