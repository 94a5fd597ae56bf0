"""The criteria of one solver: their weights and parameters in one mapping, their values as expressions."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from jtik.criterion.base import Criteria, Criterion, CriterionSum
from jtik.criterion.least_squares import LeastSquares, ResidualCriterion
from jtik.criterion.numeric import NumericCriterion
from jtik.criterion.numeric_function import NumericFunction
from jtik.criterion.overriding import belongs_to
from jtik.criterion.parameters import Check, Parameters, Parametric, checks_of, first_values
from jtik.criterion.tracing import traced, traced_gradient
from jtik.errors import ArgumentError
from jtik.robot import Kinematics, Robot
from jtik.symbolic import Expression, function, gradient, symbol, vertcat, zeros


@dataclass(frozen=True)
class CriterionTerms:
    """The criteria of one solver: weights and parameters in one mapping, values as expressions.

    Attributes:
        robot: the robot.
        named: (name, weight, criterion) of each criterion.
        parameters: live parameters, ``"name.weight"`` and ``"name.parameter"``.
    """

    robot: Robot
    named: tuple[tuple[str, float, Criterion], ...]
    parameters: Parameters

    def __str__(self) -> str:
        """The weighted sum with its present weights."""
        weights = {name: float(self.parameters[f"{name}.weight"]) for name, _, _ in self.named}
        terms = [name if weight == 1 else f"{weight:g} * {name}" for name, weight in weights.items()]
        return " + ".join(terms) or "no criterion"

    @classmethod
    def of(cls, robot: Robot, criteria: Criteria, others: Iterable[Parametric] = ()) -> CriterionTerms:
        """Reads the first value of every parameter, of the criteria and of ``others`` that share the mapping.

        Args:
            robot: the robot.
            criteria: a criterion, a sum, the name of a registered criterion, several of these, or None.
            others: clearances and the like, whose live parameters are in the same mapping.

        Raises:
            ArgumentError: when a name repeats, or a criterion has a parameter named "weight".
            CriterionError: when the parameters of a criterion are no mapping, or ``joint_parameters`` are not names in
                it.
        """
        named = CriterionSum.of(criteria).named()
        values: dict[str, ArrayLike] = {}
        of_joints, non_negative, checks = set[str](), set[str](), dict[str, Check]()
        for name, weight, criterion in named:
            values[f"{name}.weight"] = weight
            own = first_values(criterion, robot)
            if "weight" in own:
                given = f"{type(criterion).__name__}.parameters with 'weight'"
                raise ArgumentError(f"criterion {name!r}", given, "another name: it is that of the criterion's weight")
            of_joints |= {f"{name}.{parameter}" for parameter in criterion.joint_parameters}
            non_negative |= {f"{name}.{parameter}" for parameter in criterion.non_negative_parameters}
            checks |= checks_of(criterion, own, f"{name}.")
            for parameter, value in own.items():
                values[f"{name}.{parameter}"] = value
        for other in others:
            for parameter, value in other.parameters(robot).items():
                if f"{other.name}.{parameter}" in values:
                    raise ArgumentError("name", other.name, "a name that no criterion has")
                values[f"{other.name}.{parameter}"] = value
            non_negative |= {f"{other.name}.{each}" for each in getattr(other, "non_negative_parameters", ())}
            checks |= checks_of(other, other.parameters(robot), f"{other.name}.")
        return cls(robot, tuple(named), Parameters(values, robot, of_joints, non_negative, checks))

    def own(self, of: Parametric, column: Expression) -> dict[str, Expression]:
        """The parameters of one of ``others`` within the column of all, in their own shapes.

        Args:
            of: one of ``others``.
            column: all parameters, as ``parameters.symbols()`` returns them.
        """
        return {name: self.parameters.take(column, f"{of.name}.{name}") for name in of.parameters(self.robot)}

    def values(self, kinematics: Kinematics, column: Expression) -> list[Expression]:
        """Weighted value of each criterion.

        Args:
            kinematics: the robot at a symbolic configuration.
            column: all parameters, as ``parameters.symbols()`` returns them.

        Raises:
            CriterionError: when a criterion cannot be traced, is not scalar, or depends on foreign symbols.
        """
        result = []
        for name, _, criterion in self.named:
            own = self._own(name, criterion, column)
            call = lambda c=criterion, p=own: c.value(kinematics, p)  # noqa: E731
            H = traced(name, call, (kinematics.q, column))
            result.append(self.parameters.take(column, f"{name}.weight") * H)
        return result

    def value_and_gradient(self, kinematics: Kinematics, column: Expression) -> tuple[Expression, Expression] | None:
        """H and dH/dq (nq, 1) of the weighted sum; None where no criterion has a gradient of its own.

        Args:
            kinematics: the robot at a configuration of symbols.
            column: all parameters, as ``parameters.symbols()`` returns them.

        Raises:
            CriterionError: as from `values`, also where a criterion returns anything else than both or None.
        """
        theirs = [belongs_to(criterion, "value_and_gradient", "value") for _, _, criterion in self.named]
        if not any(theirs):
            return None
        H, dH = zeros(1), zeros(self.robot.nq)
        values, has_own, symbols = self.values(kinematics, column), False, (kinematics.q, column)
        for k, (name, _, criterion) in enumerate(self.named):
            if theirs[k]:
                own, weight = self._own(name, criterion, column), self.parameters.take(column, f"{name}.weight")
                call = lambda c=criterion, p=own: c.value_and_gradient(kinematics, p)  # noqa: E731
                found = traced_gradient(name, call, symbols, self.robot.nq)
                if found is not None:
                    values[k], has_own = zeros(1), True
                    H, dH = H + weight * found[0], dH + weight * found[1]
        derived = sum(values, zeros(1))
        return (H + derived, dH + gradient(derived, kinematics.q)) if has_own else None

    @cached_property
    def numeric(self) -> tuple[NumericFunction, ...]:
        """The functions of the criteria that Python evaluates."""
        return tuple(each.on(self.robot) for _, _, each in self.named if isinstance(each, NumericCriterion))

    def evaluations(self) -> int:
        """How often the functions of numeric criteria, and their gradients, have been called so far."""
        return sum(each.evaluations + each.gradients for each in self.numeric) if self.numeric else 0

    def raise_interruption(self) -> None:
        """Raise what interrupted a function of a numeric criterion, such as KeyboardInterrupt."""
        for each in self.numeric:
            each.raise_interruption()

    def least_squares(self) -> LeastSquares | None:
        """The criteria divided into those in residual form and the others; None where none is in residual form."""
        in_residual_form = [(name, each) for name, _, each in self.named if isinstance(each, ResidualCriterion)]
        if not in_residual_form:
            return None
        q, column = symbol("q", self.robot.nq), self.parameters.symbols()
        kinematics, residuals, weights = self.robot.at(q), [], []
        for name, criterion in in_residual_form:
            own = self._own(name, criterion, column)
            call = lambda c=criterion, p=own: c.residual(kinematics, p)  # noqa: E731
            r = traced(name, call, (q, column), residual=True)
            residuals.append(r)
            weights.append(self.parameters.take(column, f"{name}.weight") * np.ones(r.shape[0]))
        pairs = zip(self.values(kinematics, column), self.named, strict=True)
        rest = [H for H, (_, _, each) in pairs if not isinstance(each, ResidualCriterion)]
        return LeastSquares(
            function("residuals", [q, column], [vertcat(*residuals), vertcat(*weights)]),
            function("others", [q, column], [sum(rest, zeros(1))]),
        )

    def _own(self, name: str, criterion: Criterion, column: Expression) -> dict[str, Expression]:
        """The parameters of one criterion within the column of all, in their own shapes."""
        names = criterion.parameters(self.robot)
        return {parameter: self.parameters.take(column, f"{name}.{parameter}") for parameter in names}
