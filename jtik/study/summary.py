"""Summary of a study: one row for each contender, or for each group of other columns."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jtik.errors import ArgumentError
from jtik.result.status import Status
from jtik.types import Array

Columns = Mapping[str, NDArray[Any]]

GROUPS = ("contender", "criteria", "kind", "case", "status")
"""Columns by which rows can be grouped."""


@dataclass(frozen=True)
class SummaryColumn:
    """A column of the summary.

    Attributes:
        title: title with its unit.
        of: column of the study that it summarises.
        by: statistic of at least one number, without NaN.
        solved: whether it includes solved cases only.
        scale: factor on the result.
    """

    title: str
    of: str
    by: Callable[[Array], Any]
    solved: bool = True
    scale: float = 1.0


def _percentile(share: float) -> Callable[[Array], Any]:
    return lambda values: np.percentile(values, share)


SUMMARY_COLUMNS = (
    SummaryColumn("success [%]", "success", np.mean, False, 100.0),
    SummaryColumn("compromise [%]", "compromise", np.mean, False, 100.0),
    SummaryColumn("iterations", "iterations", np.median),
    SummaryColumn("time [ms]", "seconds", np.median, True, 1e3),
    SummaryColumn("time 10 % [ms]", "seconds", _percentile(10), True, 1e3),
    SummaryColumn("time 90 % [ms]", "seconds", _percentile(90), True, 1e3),
    SummaryColumn("time/iteration [us]", "seconds_per_iteration", np.median, False, 1e6),
    SummaryColumn("position error [m]", "position_error", np.median, False),
    SummaryColumn("orientation error [rad]", "orientation_error", np.median, False),
    SummaryColumn("H", "H", np.median),
    SummaryColumn("regret", "regret", np.median),
    SummaryColumn("monotone [%]", "monotone", np.mean, False, 100.0),
    SummaryColumn("clearance [m]", "clearance", np.min),
    SummaryColumn("limit margin [%]", "limit_margin", np.min, True, 100.0),
    SummaryColumn("leakage", "leakage", np.max, False),
    SummaryColumn("path length [rad]", "path_length", np.median),
    SummaryColumn("acceleration [rad/s^2]", "smoothness", np.median),
    SummaryColumn("drift [rad]", "drift", np.max),
    SummaryColumn("condition", "condition", np.median),
)
"""Success, compromise, errors, time per iteration, monotone and leakage include all cases; the others solved ones."""

DROPPED_FIRST = (
    "time 90 % [ms]",
    "time 10 % [ms]",
    "leakage",
    "acceleration [rad/s^2]",
    "drift [rad]",
    "time/iteration [us]",
    "condition",
    "path length [rad]",
    "monotone [%]",
    "regret",
    "limit margin [%]",
    "H",
    "clearance [m]",
    "orientation error [rad]",
    "position error [m]",
    "compromise [%]",
    "cases",
    "iterations",
    "time [ms]",
)
"""Columns that a narrow text leaves out, in this order; success stays."""


def summary(columns: Columns, by: Sequence[str]) -> dict[str, list[Any]]:
    """Columns of the summary: the groups, the number of cases, and all figures that have values.

    Args:
        columns: the columns of a study.
        by: names from `GROUPS`.

    Raises:
        ArgumentError: for another name, or no name.
    """
    names = (by,) if isinstance(by, str) else tuple(by)
    if not names or not set(names) <= set(GROUPS):
        raise ArgumentError("by", by, f"some of {', '.join(GROUPS)}")
    columns = {**columns, "compromise": _compromises(columns)}
    keys = list(zip(*[columns[name].tolist() for name in names], strict=True))
    groups = {key: np.array([each == key for each in keys]) for key in dict.fromkeys(keys)}
    table: dict[str, list[Any]] = {name: [key[i] for key in groups] for i, name in enumerate(names)}
    table["cases"] = [int(rows.sum()) for rows in groups.values()]
    for figure in SUMMARY_COLUMNS:
        values = [_summarised(columns, rows, figure) for rows in groups.values()]
        if not np.isnan(values).all():
            table[figure.title] = values
    return table


def _summarised(columns: Columns, rows: NDArray[np.bool_], figure: SummaryColumn) -> float:
    if figure.solved:
        rows = rows & columns["success"]
    values = columns[figure.of][rows].astype(float)
    values = values[~np.isnan(values)]
    return figure.scale * float(figure.by(values)) if len(values) else float("nan")


def _compromises(columns: Columns) -> Array:
    """1 for each row that ended at a compromise of task and criterion, else 0; all NaN where no row did."""
    found: Array = (columns["status"] == Status.COMPROMISE.name) & ~columns["success"]
    return np.where(found.any(), found, np.nan)
