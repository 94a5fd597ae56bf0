"""Former names of this package, kept for one release; each raises a DeprecationWarning where it is used."""

from __future__ import annotations

import math
import warnings
from typing import Any

from jtik.strategy.displacement import NullSpaceDisplacement, TaskDisplacement
from jtik.strategy.evaluation import Evaluation
from jtik.symbolic import Expression
from jtik.symbolic.factorization import RowVector


def task_move(
    term: Expression,
    image: Expression,
    length: Expression,
    alpha: Expression = math.nan,
    row_vector: RowVector | None = None,
) -> TaskDisplacement:
    """A task displacement from the ``term`` that is subtracted from q."""
    rows = None if row_vector is None else -1 * row_vector
    return TaskDisplacement(-term, -image, length, alpha, rows)


def null_move(
    term: Expression, length: Expression, decrease: Expression, beta: Expression = math.nan, **options: Any
) -> NullSpaceDisplacement:
    """A null-space displacement from the ``term`` that is subtracted from q."""
    renamed = {"unsteady": "stationarity_residual", "keeps_limits": "within_limits", "gave_way": "relaxed"}
    options = {renamed.get(name, name): value for name, value in options.items()}
    return NullSpaceDisplacement(-term, length, decrease, beta, **options)


RENAMED: dict[str, tuple[str, Any]] = {
    "TaskMove": ("TaskDisplacement, whose dq is added to q", task_move),
    "NullMove": ("NullSpaceDisplacement, whose dq is added to q", null_move),
    "Point": ("Evaluation", Evaluation),
}
"""Former name -> (present name and difference, replacement)."""


def former(name: str) -> Any:
    """The replacement of a former name, with a DeprecationWarning. Raises AttributeError for any other name."""
    if name not in RENAMED:
        raise AttributeError(f"module 'jtik.strategy' has no attribute {name!r}")
    present, stand_in = RENAMED[name]
    warnings.warn(f"jtik.strategy.{name} is now called {present}", DeprecationWarning, stacklevel=3)
    return stand_in
