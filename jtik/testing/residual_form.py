"""The contract of a criterion in residual form: H = 1/2 |r|^2, with a Jacobian of r that belongs to the gradient."""

from __future__ import annotations

import numpy as np

from jtik.criterion import CriterionTerms
from jtik.symbolic import function, jacobian, substitute, symbol, zeros
from jtik.symbolic.compile import CompiledFunction
from jtik.testing.common import require
from jtik.types import Array

TOLERANCE = 1e-9
"""Relative disagreement allowed between H and 1/2 |r|^2, and between the gradient and A' r: rounding."""


def check_residual_form(who: str, terms: CriterionTerms, q: Array, value: float, gradient: Array) -> None:
    """Check the residual of the only criterion of ``terms`` at q.

    Args:
        who: how a message begins.
        terms: the criterion.
        q: configuration, (nq,).
        value: H at q.
        gradient: dH/dv at q, (n,).

    Raises:
        AssertionError: when the residual does not belong to H and its gradient.
    """
    parts = terms.least_squares()
    assert parts is not None
    at, parameters, v = symbol("q", terms.robot.nq), terms.parameters.symbols(), symbol("v", terms.robot.n)
    r, _ = parts.residuals(terms.robot.integrate(at, v), parameters)
    results = [substitute(each, v, zeros(terms.robot.n)) for each in (r, jacobian(r, v))]
    evaluate = CompiledFunction(function("residual_form", [at, parameters], results))
    residual, A = evaluate(q, terms.parameters.memory)
    half = float(residual[:, 0] @ residual[:, 0]) / 2
    require(
        abs(half - value) <= TOLERANCE * max(1.0, abs(value)),
        f"{who} is {value} and half its squared residual is {half}, at q = {q.tolist()}",
    )
    require(bool(np.isfinite(A).all()), f"the Jacobian of the residual of {who} is {A} at q = {q.tolist()}")
    along = A.T @ residual[:, 0]
    require(
        bool(np.abs(along - gradient).max() <= TOLERANCE * max(1.0, float(np.abs(gradient).max()))),
        f"the gradient of {who} is {gradient}, and A' r of its residual is {along}, at q = {q.tolist()}",
    )
