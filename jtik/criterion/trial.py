"""Trial of the criteria of a solver at a few configurations: a value that is not finite there is refused at once."""

from __future__ import annotations

import numpy as np

from jtik.criterion.numeric import NumericCriterion
from jtik.criterion.terms import CriterionTerms
from jtik.criterion.tracing import CriterionError
from jtik.errors import ArgumentError
from jtik.robot import Robot
from jtik.symbolic import Function, gradient, symbol
from jtik.symbolic.compile import CompiledFunction
from jtik.types import Array

CONFIGURATIONS = 5
"""Number of configurations tried: `Robot.home`, where a solve starts by default, and random ones within the limits."""


def check_finite(terms: CriterionTerms, values: Function) -> None:
    """Evaluate every criterion at the first configurations, with the first values of its parameters.

    A criterion may have no value in a part of the space, such as behind a barrier: no step leads there. It must have
    one where a solve starts by default, and at one of the random configurations.

    Args:
        terms: the criteria.
        values: (q, parameters) -> the weighted value of each criterion.

    Raises:
        CriterionError: when a numeric criterion raises an error or returns no number; when a function that a criterion
            calls has no derivative; when a value is not finite at home, or at all random configurations. The message
            contains the configuration.
    """
    if not terms.named:
        return
    for name, _, criterion in terms.named:
        if isinstance(criterion, NumericCriterion):
            column = _column(terms, name, criterion)
            for q in _configurations(terms.robot):
                criterion.check(terms.robot, q, column)
    if values.find_functions():
        _check_derivatives(terms, values)
    evaluate, tried = CompiledFunction(values), _configurations(terms.robot)
    found = np.array([evaluate(q, terms.parameters.memory)[0][:, 0] for q in tried])
    for (name, _, _), own in zip(terms.named, found.T, strict=True):
        finite = np.isfinite(own)
        if finite[0] and finite[1:].any():
            continue
        k = int(finite[0])
        at = np.array2string(tried[k], separator=", ", max_line_width=1000)
        where = "" if k == 0 else f", and not finite at {CONFIGURATIONS - 2} more random configurations"
        raise CriterionError(
            name,
            f"is {own[k]} at q = {at}{where}; expected a finite number. Bound logarithms, roots and divisions, for "
            "instance by casadi.fmax, or give its parameters other first values",
        )


def check_compiled(terms: CriterionTerms, values: Function) -> None:
    """Refuse ``compiled=True`` beside a criterion that Python evaluates.

    Args:
        terms: the criteria.
        values: (q, parameters) -> the weighted value of each criterion.

    Raises:
        ArgumentError: when there is such a criterion.
    """
    accepted = "False: Python evaluates it, and generated C cannot call Python"
    for name, _, criterion in terms.named:
        if isinstance(criterion, NumericCriterion):
            raise ArgumentError("compiled", f"True with the numeric criterion {name!r}", accepted)
    for called in values.find_functions():
        if called.class_name() == "CallbackInternal":
            raise ArgumentError("compiled", f"True with the casadi.Callback {called.name()!r} in a criterion", accepted)


def _check_derivatives(terms: CriterionTerms, values: Function) -> None:
    """Raise CriterionError for a criterion that calls a function without a derivative, such as a bare Callback."""
    q, column = symbol("q", terms.robot.nq), terms.parameters.symbols()
    for (name, _, _), H in zip(terms.named, terms.values(terms.robot.at(q), column), strict=True):
        try:
            gradient(H, q)
        except RuntimeError as error:
            reason = str(error).strip().splitlines()[-1].rstrip(".")
            advice = "give it a Jacobian, or make it a criterion by @jtik.criterion(numeric=True)"
            raise CriterionError(name, f"{reason}: {advice}") from error


def _configurations(robot: Robot) -> list[Array]:
    """`Robot.home`, and random configurations within the limits."""
    generator = np.random.default_rng(0)
    return [robot.home, *[robot.random_configuration(generator) for _ in range(CONFIGURATIONS - 1)]]


def _column(terms: CriterionTerms, name: str, criterion: NumericCriterion) -> Array:
    """The values of the parameters of a criterion in one column."""
    values = [terms.parameters[f"{name}.{own}"].ravel(order="F") for own in criterion.parameters(terms.robot)]
    return np.concatenate([*values, np.zeros(0)])
