"""The summary of a study: one line a contender, or whatever else the rows are grouped by."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jtik.errors import ArgumentError
from jtik.types import Array

Columns = Mapping[str, NDArray[Any]]

GROUPS = ("contender", "criteria", "kind", "case", "status")
"""What rows can be grouped by."""


@dataclass(frozen=True)
class Figure:
    """A column of the summary.

    Attributes:
        title: what it is called, with its unit.
        of: the column of the study that it summarises.
        by: how: numbers without NaN, at least one of them -> one number.
        solved: whether only solved cases count.
        scale: what the number is multiplied by.
    """

    title: str
    of: str
    by: Callable[[Array], Any]
    solved: bool = True
    scale: float = 1.0


def _percentile(share: float) -> Callable[[Array], Any]:
    return lambda values: np.percentile(values, share)


FIGURES = (
    Figure("success [%]", "success", np.mean, False, 100.0),
    Figure("iterations", "iterations", np.median),
    Figure("time [ms]", "seconds", np.median, True, 1e3),
    Figure("time 10 % [ms]", "seconds", _percentile(10), True, 1e3),
    Figure("time 90 % [ms]", "seconds", _percentile(90), True, 1e3),
    Figure("time/iteration [us]", "seconds_per_iteration", np.median, False, 1e6),
    Figure("position error [m]", "position_error", np.median, False),
    Figure("orientation error [rad]", "orientation_error", np.median, False),
    Figure("H", "H", np.median),
    Figure("regret", "regret", np.median),
    Figure("monotone [%]", "monotone", np.mean, False, 100.0),
    Figure("clearance [m]", "clearance", np.min),
    Figure("limit margin [%]", "limit_margin", np.min, True, 100.0),
    Figure("leakage", "leakage", np.max, False),
    Figure("path length [rad]", "path_length", np.median),
    Figure("acceleration [rad/s^2]", "smoothness", np.median),
    Figure("drift [rad]", "drift", np.max),
    Figure("condition", "condition", np.median),
)
"""Success, monotony, leakage and the errors are of all cases; the rest is of the solved ones."""


def summary(columns: Columns, by: Sequence[str]) -> dict[str, list[Any]]:
    """Columns of the summary: what it is grouped by, how many cases, and every figure that there is.

    Args:
        columns: those of a study.
        by: names from `GROUPS`.

    Raises:
        ArgumentError: for another name, or none.
    """
    names = (by,) if isinstance(by, str) else tuple(by)
    if not names or not set(names) <= set(GROUPS):
        raise ArgumentError("by", by, f"some of {', '.join(GROUPS)}")
    keys = list(zip(*[columns[name].tolist() for name in names], strict=True))
    groups = {key: np.array([each == key for each in keys]) for key in dict.fromkeys(keys)}
    table: dict[str, list[Any]] = {name: [key[i] for key in groups] for i, name in enumerate(names)}
    table["cases"] = [int(rows.sum()) for rows in groups.values()]
    for figure in FIGURES:
        values = [_summarised(columns, rows, figure) for rows in groups.values()]
        if not np.isnan(values).all():
            table[figure.title] = values
    return table


def _summarised(columns: Columns, rows: NDArray[np.bool_], figure: Figure) -> float:
    if figure.solved:
        rows = rows & columns["success"]
    values = columns[figure.of][rows].astype(float)
    values = values[~np.isnan(values)]
    return figure.scale * float(figure.by(values)) if len(values) else float("nan")
