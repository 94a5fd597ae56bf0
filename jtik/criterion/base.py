"""The secondary: a scalar H(q) to be minimised by the freedom the task leaves, with live parameters.

A criterion is a pure function of q and of named parameters, made of operations CasADi can trace. Its gradient
follows; nobody writes it. Parameters stay inputs of the compiled step, so changing one costs a copy.
"""

from __future__ import annotations

import inspect
import re
import sys
import traceback
import warnings
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, MutableMapping
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

import numpy as np
from numpy.typing import ArrayLike

from jtik.errors import ArgumentError, JtikError, UnknownNameError, finite_array
from jtik.robot import Kinematics, Robot
from jtik.symbolic import SX, Expression, is_symbolic, no_silent_float, reshape, symbol, symvar
from jtik.types import Array


class CriterionError(JtikError):
    """A criterion that cannot be used: not scalar, not traceable, or made of foreign symbols.

    Attributes: criterion (its name), reason.
    """

    def __init__(self, criterion: str, reason: str) -> None:
        super().__init__(criterion, reason)
        self.criterion = criterion
        self.reason = reason

    def __str__(self) -> str:
        return f"criterion {self.criterion!r}: {self.reason}"


class Criterion(ABC):
    """A function H(q) to minimise. Subclass it where a decorated function is not enough.

    ``name`` is how its parameters are addressed (``ik.parameters["name.parameter"]``) and how a Solution lists it; the
    class's own name in lower case with underscores, unless the subclass sets another. ``summary`` is one line for
    lists, ``source`` names the paper.
    Criteria add and scale: ``1.0 * A() + 0.3 * B()``; a bigger weight is a stronger pull.
    """

    name: str
    summary: ClassVar[str] = ""
    source: ClassVar[str] = ""

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        if "name" not in vars(cls):
            cls.name = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", cls.__name__).lower()

    def parameters(self, robot: Robot) -> Mapping[str, ArrayLike]:
        """Names and first values of the live parameters on this robot; scalars, vectors or matrices."""
        return {}

    def __repr__(self) -> str:
        return f"{type(self).__name__}(name={self.name!r})"

    @abstractmethod
    def value(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> Expression:
        """H at ``kinematics.q`` as a scalar expression; parameters have the shapes of their first values."""

    def __add__(self, other: Criterion) -> CriterionSum:
        return CriterionSum.of(self) + other

    def __mul__(self, weight: float) -> CriterionSum:
        return CriterionSum.of(self) * weight

    __rmul__ = __mul__


@dataclass(frozen=True)
class CriterionSum:
    """A weighted sum of criteria; each weight is itself a live parameter, ``"name.weight"``."""

    terms: tuple[tuple[float, Criterion], ...]

    @classmethod
    def of(cls, criteria: Criterion | CriterionSum | None) -> CriterionSum:
        """The sum with one term of weight 1, the sum itself, or the empty sum."""
        if criteria is None:
            return cls(())
        if isinstance(criteria, CriterionSum):
            return criteria
        if isinstance(criteria, Criterion):
            return cls(((1.0, criteria),))
        raise ArgumentError("criteria", criteria, "a jtik.Criterion, a weighted sum of them, or None")

    def __add__(self, other: Criterion | CriterionSum) -> CriterionSum:
        if not isinstance(other, (Criterion, CriterionSum)):
            return NotImplemented
        return CriterionSum(self.terms + CriterionSum.of(other).terms)

    def __mul__(self, weight: float) -> CriterionSum:
        factor = float(finite_array("weight", weight, ()))
        if factor < 0:
            raise ArgumentError("weight", weight, "a finite number from 0")
        return CriterionSum(tuple((factor * own, criterion) for own, criterion in self.terms))

    __rmul__ = __mul__

    def __len__(self) -> int:
        return len(self.terms)

    def named(self) -> list[tuple[str, float, Criterion]]:
        """(name, weight, criterion) of each term; a name that comes again gets a number: ``name_2``."""
        result: list[tuple[str, float, Criterion]] = []
        taken: set[str] = set()
        for weight, criterion in self.terms:
            name, count = criterion.name, 1
            while name in taken:
                count += 1
                name = f"{criterion.name}_{count}"
            taken.add(name)
            result.append((name, weight, criterion))
        return result


class Parameters(MutableMapping[str, Array]):
    """Live parameters by name. Assigning one writes into the memory the compiled step reads: no recompilation.

    A value read is a copy; ``parameters["a.b"][0] = 1`` therefore changes nothing: assign the whole value.
    """

    def __init__(self, values: Mapping[str, ArrayLike], weights: Collection[str] = ()) -> None:
        self.weights = frozenset(weights)
        """Names of those that may not be negative: the weights of criteria."""
        self._shapes: dict[str, tuple[int, ...]] = {}
        self._slices: dict[str, slice] = {}
        flat: list[Array] = []
        start = 0
        for name, value in values.items():
            array = np.array(value, dtype=float)
            if array.ndim > 2 or not np.all(np.isfinite(array)):
                raise ArgumentError(name, value, "a finite scalar, vector or matrix")
            self._shapes[name] = array.shape
            self._slices[name] = slice(start, start + array.size)
            flat.append(array.ravel(order="F"))
            start += array.size
        self.memory: Array = np.concatenate([*flat, np.zeros(0)])
        """All values, one after the other, matrices columns first: bound to the compiled functions."""

    def __getitem__(self, name: str) -> Array:
        if name not in self._slices:
            raise UnknownNameError("parameter", name, self._slices)
        return self.memory[self._slices[name]].reshape(self._shapes[name], order="F").copy()

    def __setitem__(self, name: str, value: ArrayLike) -> None:
        if name not in self._slices:
            raise UnknownNameError("parameter", name, self._slices)
        shape = self._shapes[name]
        try:
            array = np.array(value, dtype=float)
        except (TypeError, ValueError):
            raise ArgumentError(name, value, f"numbers of shape {shape}") from None
        if array.shape != shape or not np.all(np.isfinite(array)):
            raise ArgumentError(name, value, f"finite numbers of shape {shape}")
        if name in self.weights and array < 0:
            raise ArgumentError(name, value, "a finite number from 0")
        self.memory[self._slices[name]] = array.ravel(order="F")

    def __delitem__(self, name: str) -> None:
        raise TypeError("parameters can be changed, not removed")

    def __iter__(self) -> Iterator[str]:
        return iter(self._slices)

    def __len__(self) -> int:
        return len(self._slices)

    def __repr__(self) -> str:
        return "\n".join(f"{name} = {self[name].tolist()}" for name in self) or "no parameters"

    def symbols(self) -> Expression:
        """One column of symbols for all of them."""
        return symbol("parameters", self.memory.size)

    def take(self, column: Expression, name: str) -> Expression:
        """The expression of one parameter within that column, in its own shape."""
        shape = (*self._shapes[name], 1, 1)[:2]
        return reshape(column[self._slices[name]], *shape)


class Parametric(Protocol):
    """What has live parameters under a name."""

    name: str

    def parameters(self, robot: Robot) -> Mapping[str, ArrayLike]:
        """Names and first values."""


@dataclass(frozen=True)
class CriterionTerms:
    """The criteria of one solver, laid out: weights and parameters in one mapping, values as expressions."""

    robot: Robot
    named: tuple[tuple[str, float, Criterion], ...]
    parameters: Parameters

    @classmethod
    def of(
        cls, robot: Robot, criteria: Criterion | CriterionSum | None, others: Iterable[Parametric] = ()
    ) -> CriterionTerms:
        """Reads the first value of every parameter, of the criteria and of ``others`` that share the mapping."""
        named = CriterionSum.of(criteria).named()
        values: dict[str, ArrayLike] = {}
        for name, weight, criterion in named:
            values[f"{name}.weight"] = weight
            for parameter, value in criterion.parameters(robot).items():
                values[f"{name}.{parameter}"] = value
        for other in others:
            for parameter, value in other.parameters(robot).items():
                if f"{other.name}.{parameter}" in values:
                    raise ArgumentError("name", other.name, "one that no criterion has")
                values[f"{other.name}.{parameter}"] = value
        return cls(robot, tuple(named), Parameters(values, [f"{name}.weight" for name, _, _ in named]))

    def own(self, of: Parametric, column: Expression) -> dict[str, Expression]:
        """The parameters of one of ``others`` within the column of all, in their own shapes."""
        return {name: self.parameters.take(column, f"{of.name}.{name}") for name in of.parameters(self.robot)}

    def values(self, kinematics: Kinematics, column: Expression) -> list[Expression]:
        """Weighted value of each criterion. Raises CriterionError where one cannot be traced or is not scalar."""
        result = []
        for name, _, criterion in self.named:
            own = {
                parameter: self.parameters.take(column, f"{name}.{parameter}")
                for parameter in criterion.parameters(self.robot)
            }
            H = _trace(name, lambda c=criterion, p=own: c.value(kinematics, p))  # type: ignore[misc]
            known = {symbol.element_hash() for symbol in (*symvar(kinematics.q), *symvar(column))}
            foreign = [str(symbol) for symbol in symvar(H) if symbol.element_hash() not in known]
            if foreign:
                raise CriterionError(name, f"depends on symbols that are not its own: {', '.join(foreign)}")
            result.append(self.parameters.take(column, f"{name}.weight") * H)
        return result


def _trace(name: str, call: Callable[[], Any]) -> Expression:
    """The criterion's expression; what goes wrong while tracing is told with the line it went wrong in."""
    try:
        with warnings.catch_warnings():
            # numpy.sin(q) is welcome here; CasADi's notice about numpy functions of its expressions is not news
            warnings.filterwarnings("ignore", r"\s*casadi: a numpy function", FutureWarning)
            with no_silent_float():
                H = call()
    except JtikError:
        raise
    except Exception as error:
        frames = traceback.extract_tb(error.__traceback__)
        libraries = ("casadi", "numpy", "jtik/symbolic")
        own = [frame for frame in frames if not any(library in frame.filename for library in libraries)]
        line = (own or frames)[-1]
        reason = (str(error).strip() or type(error).__name__).splitlines()[0]
        raise CriterionError(
            name,
            f"CasADi cannot trace the operation `{line.line}` (line {line.lineno} of {line.filename}): {reason}. "
            "Use operations that accept expressions, such as numpy.sin, casadi.norm_2, casadi.fmax and casadi.if_else, "
            "in place of math functions, comparisons in `if` and numpy.linalg",
        ) from error
    if not is_symbolic(H):
        try:
            H = SX(float(H))
        except (TypeError, ValueError):
            raise CriterionError(name, f"must return one scalar expression, not {type(H).__name__}") from None
    if H.shape != (1, 1):
        rows, columns = H.shape
        raise CriterionError(name, f"must return a scalar, not shape ({rows}, {columns}); sum it, or take its norm")
    return H


class FunctionCriterion(Criterion):
    """A user's function as a criterion; made by ``@jtik.criterion``.

    Keyword-only arguments of the function are its live parameters, their defaults the first values. Calling it
    with some of them, ``f(height=0.3)``, gives the criterion with other first values.
    """

    def __init__(self, function: Callable[..., Any], name: str, defaults: Mapping[str, ArrayLike]) -> None:
        self._function = function
        self._defaults = dict(defaults)
        self.name = name
        self.__doc__ = function.__doc__

    def __call__(self, **defaults: ArrayLike) -> FunctionCriterion:
        """The same criterion with other first values. Raises UnknownNameError for a parameter it does not have."""
        unknown = sorted(set(defaults) - set(self._defaults))
        if unknown:
            raise UnknownNameError("parameter", unknown[0], self._defaults)
        return FunctionCriterion(self._function, self.name, {**self._defaults, **defaults})

    def __repr__(self) -> str:
        return f"{self.name}({', '.join(f'{key}={value}' for key, value in self._defaults.items())})"

    def parameters(self, robot: Robot) -> Mapping[str, ArrayLike]:
        """The keyword-only arguments."""
        return self._defaults

    def value(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> Expression:
        """The function at ``(q, robot)``."""
        return self._function(kinematics.q, kinematics.robot, **parameters)


def criterion(function: Callable[..., Any]) -> FunctionCriterion:
    """Make ``def f(q, robot, *, parameter=first_value): ...`` a criterion to be minimised.

    ``q`` is the symbolic configuration (nq, 1), ``robot`` gives ``robot.position(q, frame)``, ``robot.pose`` and
    ``robot.jacobian`` of it. Raises ArgumentError when the signature is another or a parameter has no first value.
    """
    accepted = "a function f(q, robot, *, parameter=first_value, ...)"
    if not callable(function):
        raise ArgumentError("function", function, accepted)
    positional, defaults = 0, {}
    for parameter in inspect.signature(function).parameters.values():
        if parameter.kind is parameter.KEYWORD_ONLY and parameter.default is not parameter.empty:
            defaults[parameter.name] = parameter.default
        elif parameter.kind in (parameter.POSITIONAL_ONLY, parameter.POSITIONAL_OR_KEYWORD):
            positional += 1
        else:
            raise ArgumentError(f"parameter {parameter.name!r} of {function.__name__}", parameter, accepted)
    if positional != 2:
        raise ArgumentError(function.__name__, f"{positional} positional arguments", accepted)
    if getattr(sys.modules.get(function.__module__), function.__name__, None) is not function:
        # a function is pickled as the name it is found under, and that name will be the criterion's
        function.__qualname__ += "._function"
    return FunctionCriterion(function, function.__name__, defaults)
