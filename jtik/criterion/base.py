"""Criteria: scalars H(q) that a redundant robot minimises besides its task, with live parameters.

A criterion is a pure function of q and of named parameters, made of operations CasADi can trace. Its gradient is
derived from it by CasADi. Parameters stay inputs of the compiled step, so changing one costs a copy.
"""

from __future__ import annotations

import re
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from jtik.arguments import number, several
from jtik.constructors import Constructed
from jtik.criterion import evaluation
from jtik.criterion.criteria_argument import hint, registered
from jtik.criterion.tracing import CriterionError
from jtik.errors import ArgumentError, UnknownNameError
from jtik.robot import Kinematics, Robot
from jtik.symbolic import Expression, is_symbolic
from jtik.types import Array

__all__ = ["Criteria", "Criterion", "CriterionError", "CriterionSum"]


class _Algebra:
    """Sums and multiples of criteria, the same for one criterion and for a sum."""

    __array_ufunc__ = None  # NumPy numbers on the left leave the multiplication to __rmul__

    def __add__(self, other: Any) -> CriterionSum:
        return CriterionSum(_terms(self) + _terms(other)) if _is_summand(other) else NotImplemented

    def __radd__(self, other: Any) -> CriterionSum:
        return CriterionSum(_terms(other) + _terms(self)) if _is_summand(other) else NotImplemented

    def __sub__(self, other: Any) -> CriterionSum:
        return self + CriterionSum(_terms(other)) * -1 if _is_summand(other) else NotImplemented

    def __rsub__(self, other: Any) -> CriterionSum:
        return CriterionSum(_terms(other)) - self if _is_summand(other) else NotImplemented

    def __pos__(self) -> CriterionSum:
        return CriterionSum(_terms(self))

    def __neg__(self) -> CriterionSum:
        return self * -1

    def __mul__(self, weight: float) -> CriterionSum:
        factor = number("weight", weight)
        return _weighted((factor * own, criterion) for own, criterion in _terms(self))

    __rmul__ = __mul__

    def __truediv__(self, divisor: float) -> CriterionSum:
        ratio = number("divisor", divisor, "a finite number other than 0")
        if ratio == 0:
            raise ArgumentError("divisor", divisor, "a finite number other than 0")
        return _weighted((own / ratio, criterion) for own, criterion in _terms(self))


class Criterion(_Algebra, metaclass=Constructed):
    """A function H(q) to minimise. Subclass it where a decorated function is not enough.

    Criteria add and scale: ``1.0 * A() + 0.3 * B()``. A larger weight makes a criterion count more. A negative weight
    maximises it: ``-A()``, ``A() - 0.3 * B()``.

    ``criterion(q, robot)`` is H as a number, ``criterion.gradient(q, robot)`` its gradient.

    Attributes:
        name: the first part of the names of its parameters (``ik.parameters["name.parameter"]``) and its name in a
            Solution; the class's name in lower case with underscores, unless the subclass sets another.
        summary: one line for lists of criteria.
        source: the paper it comes from.
        bibtex: BibTeX entries of the source, for `jtik.citations`.
        joint_parameters: names of the live parameters with one number for each entry of q, as `Robot.joint_values`
            returns them; they can also be assigned as numbers of the full robot, or as a dict by joint name.
        non_negative_parameters: names of the live parameters that no negative number can be assigned to.

    Example:
        >>> both = 1.0 * JointCentering() + 0.3 * Manipulability(kind="position")
        >>> round(both([0.1, 0.2, 0.3], jtik.Robot.planar(3)), 3)
        0.049
    """

    name: str
    summary: ClassVar[str] = ""
    source: ClassVar[str] = ""
    bibtex: ClassVar[str] = ""
    joint_parameters: ClassVar[tuple[str, ...]] = ()
    non_negative_parameters: ClassVar[tuple[str, ...]] = ()

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        if "name" not in vars(cls):
            cls.name = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", cls.__name__).lower()

    def parameters(self, robot: Robot) -> Mapping[str, ArrayLike]:
        """Names and first values of the live parameters on this robot; scalars, vectors or matrices.

        Args:
            robot: the robot.
        """
        return {}

    def accepted_instead(self, parameter: str, value: Array) -> str | None:
        """Judge a value that is assigned to a live parameter: finite numbers of its shape.

        Args:
            parameter: name of the live parameter, without that of the criterion.
            value: the value assigned to it.

        Returns:
            None where it is accepted, else what would be accepted instead, for the error.
        """
        return None

    def __repr__(self) -> str:
        return f"{type(self).__name__}(name={self.name!r})"

    @abstractmethod
    def value(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> Expression:
        """H at ``kinematics.q`` as a scalar expression; parameters have the shapes of their first values.

        Args:
            kinematics: the robot at a symbolic configuration.
            parameters: expressions of the live parameters by name.
        """

    def value_and_gradient(
        self, kinematics: Kinematics, parameters: Mapping[str, Expression]
    ) -> tuple[Expression, Expression] | None:
        """H and dH/dq (nq, 1), where these take fewer operations than what CasADi derives from `value`.

        A step uses them for its gradient; second derivatives are those of `value`. `jtik.testing.check_criterion`
        compares both.

        Args:
            kinematics: the robot at a configuration of symbols.
            parameters: expressions of the live parameters by name.

        Returns:
            Both, or None where the gradient is derived from `value`.
        """
        return None

    def __call__(self, q: Any, robot: Robot, **parameters: Any) -> Any:
        """H at q. It is compiled once for each criterion and robot.

        Within another criterion ``q`` is an expression, and so is the result.

        Args:
            q: configuration (nq,) [rad] or [m], or an expression (nq, 1).
            robot: the robot.
            parameters: values of live parameters by name; the others have their first values.

        Returns:
            A float; an expression where q or a parameter is one.

        Raises:
            ArgumentError: when q, the robot or the value of a parameter cannot be used.
            UnknownNameError: when there is no parameter of that name.
            CriterionError: when the criterion cannot be traced.
        """
        return evaluation.value(self, q, robot, parameters)

    def gradient(self, q: Any, robot: Robot, **parameters: Any) -> Any:
        """The gradient of H with respect to the velocity, dH/dv; arguments and errors as those of a call.

        Args:
            q: configuration (nq,) [rad] or [m], or an expression (nq, 1).
            robot: the robot.
            parameters: values of live parameters by name; the others have their first values.

        Returns:
            An array (n,); an expression (n, 1) where q or a parameter is an expression.
        """
        return evaluation.derivative(self, q, robot, parameters)


@dataclass(frozen=True)
class CriterionSum(_Algebra, metaclass=Constructed):
    """A weighted sum of criteria; each weight is itself a live parameter, ``"name.weight"``.

    A weight is any finite number, in the sum and as a live parameter; a negative weight maximises its criterion.

    Attributes:
        terms: (weight, criterion) of each criterion.

    Raises:
        ArgumentError: for anything else.
    """

    terms: tuple[tuple[float, Criterion], ...]

    def __post_init__(self) -> None:
        accepted = "pairs of a weight, a finite number, and a jtik.Criterion"
        terms = []
        for pair in several("terms", self.terms, accepted):
            if not isinstance(pair, (tuple, list)) or len(pair) != 2 or not isinstance(pair[1], Criterion):
                raise ArgumentError("terms", pair, accepted)
            terms.append((number("weight", pair[0]), pair[1]))
        object.__setattr__(self, "terms", tuple(terms))

    @classmethod
    def of(cls, criteria: Criteria) -> CriterionSum:
        """What ``criteria=`` accepts as one sum.

        Args:
            criteria: a criterion (weight 1), a sum, the name of a registered criterion, a list or tuple of these, or
                None for the empty sum.

        Raises:
            ArgumentError: for anything else, and for a name whose class needs arguments.
            UnknownNameError: when no criterion is registered under a name.
        """
        if criteria is None:
            return cls(())
        if isinstance(criteria, CriterionSum):
            return criteria
        if isinstance(criteria, Criterion):
            return cls(((1.0, criteria),))
        if isinstance(criteria, str):
            return cls(((1.0, registered(criteria)),))
        if isinstance(criteria, (list, tuple)):
            return cls(tuple(term for each in criteria for term in cls.of(each).terms))
        raise ArgumentError("criteria", *hint(criteria, Criterion))

    def __call__(self, q: Any, robot: Robot, **parameters: Any) -> Any:
        """The weighted sum at q.

        Args:
            q: configuration (nq,) [rad] or [m], or an expression (nq, 1).
            robot: the robot.
            parameters: values of live parameters and weights by their full names, such as
                ``**{"joint_centering.weight": 2.0}``; the others have their first values.

        Returns:
            A float; an expression where q or a parameter is one.

        Raises:
            ArgumentError: when q, the robot or the value of a parameter cannot be used.
            UnknownNameError: when there is no parameter of that name.
            CriterionError: when a criterion cannot be traced.
        """
        at = evaluation.checked_configuration(q, evaluation.checked_robot(robot))
        total: Any = type(at)(0) if is_symbolic(at) else 0.0
        for weight, criterion, own in self._evaluable(robot, parameters):
            total = total + weight * criterion(at, robot, **own)
        return total

    def gradient(self, q: Any, robot: Robot, **parameters: Any) -> Any:
        """The gradient of the sum with respect to the velocity; arguments and errors as those of a call.

        Args:
            q: configuration (nq,) [rad] or [m], or an expression (nq, 1).
            robot: the robot.
            parameters: values of live parameters and weights by their full names; the others have their first values.

        Returns:
            An array (n,); an expression (n, 1) where q or a parameter is an expression.
        """
        at = evaluation.checked_configuration(q, evaluation.checked_robot(robot))
        total: Any = type(at).zeros(robot.n) if is_symbolic(at) else np.zeros(robot.n)
        for weight, criterion, own in self._evaluable(robot, parameters):
            total = total + weight * criterion.gradient(at, robot, **own)
        return total

    def __len__(self) -> int:
        return len(self.terms)

    def __repr__(self) -> str:
        text = ""
        for weight, criterion in self.terms:
            sign = ("- " if text else "-") if weight < 0 else ("+ " if text else "")
            factor = "" if abs(weight) == 1 else f"{abs(weight)!r} * "
            text += f"{' ' if text else ''}{sign}{factor}{criterion!r}"
        return text or "CriterionSum(())"

    def named(self) -> list[tuple[str, float, Criterion]]:
        """(name, weight, criterion) of each criterion; a name that comes again gets a number: ``name_2``."""
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

    def _evaluable(self, robot: Robot, given: Mapping[str, Any]) -> list[tuple[Any, Criterion, dict[str, Any]]]:
        """Weight, criterion and given values of its own parameters, of each criterion."""
        rest = dict(given)
        known: list[str] = []
        result: list[tuple[Any, Criterion, dict[str, Any]]] = []
        for name, first, criterion in self.named():
            weight = rest.pop(f"{name}.weight", first)
            if not is_symbolic(weight):
                weight = number(f"{name}.weight", weight)
            full = {parameter: f"{name}.{parameter}" for parameter in criterion.parameters(robot)}
            own = {parameter: rest.pop(text) for parameter, text in full.items() if text in rest}
            result.append((weight, criterion, own))
            known += [f"{name}.weight", *full.values()]
        for unknown in rest:
            raise UnknownNameError("parameter", unknown, known)
        return result


Criteria: TypeAlias = Criterion | CriterionSum | str | Sequence["Criteria"] | None
"""What ``criteria=`` accepts: a criterion, a sum, a registered name, a list of these, or None."""


def _is_summand(other: Any) -> bool:
    """Whether it can be added: a criterion, a sum, or the 0 that ``sum([A, B])`` begins with."""
    return isinstance(other, _Algebra) or (isinstance(other, (int, float)) and other == 0)


def _terms(summand: Any) -> tuple[tuple[float, Criterion], ...]:
    """(weight, criterion) of each criterion of a summand; none of 0."""
    return CriterionSum.of(summand).terms if isinstance(summand, (Criterion, CriterionSum)) else ()


def _weighted(terms: Any) -> CriterionSum:
    """The sum of these (weight, criterion). Raises ArgumentError for a weight that is not finite."""
    return CriterionSum(tuple(terms))
