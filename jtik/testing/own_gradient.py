"""The contract of a criterion that gives value and gradient together: they are those of its value."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from jtik.criterion import CriterionTerms
from jtik.symbolic import function, symbol
from jtik.symbolic.compile import CompiledFunction
from jtik.testing.common import require
from jtik.types import Array

TOLERANCE = 1e-9
"""Relative disagreement allowed between both: rounding."""


def own_gradient(terms: CriterionTerms) -> Callable[..., Sequence[Array]] | None:
    """(q, parameters) -> H, dH/dv of the criteria by `Criterion.value_and_gradient`; None where none has it.

    Args:
        terms: the criteria.
    """
    q, parameters = symbol("q", terms.robot.nq), terms.parameters.symbols()
    found = terms.value_and_gradient(terms.robot.at(q), parameters)
    if found is None:
        return None
    along = terms.robot.tangent(q).T @ found[1]
    return CompiledFunction(function("own_gradient", [q, parameters], [found[0], along]))


def check_own_gradient(who: str, q: Array, value: float, gradient: Array, own: Sequence[Array]) -> None:
    """Check value and gradient by `Criterion.value_and_gradient` at q.

    Args:
        who: how a message begins.
        q: configuration, (nq,).
        value: H at q.
        gradient: dH/dv at q, (n,), derived from `Criterion.value`.
        own: both by `Criterion.value_and_gradient`.

    Raises:
        AssertionError: when they disagree.
    """
    H, along = float(own[0][0, 0]), own[1][:, 0]
    require(
        abs(H - value) <= TOLERANCE * max(1.0, abs(value)),
        f"{who} is {value}, and by value_and_gradient {H}, at q = {q.tolist()}",
    )
    require(
        bool(np.abs(along - gradient).max() <= TOLERANCE * max(1.0, float(np.abs(gradient).max()))),
        f"the gradient of {who} is {gradient}, and by value_and_gradient {along}, at q = {q.tolist()}",
    )
