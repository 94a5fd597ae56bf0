"""Which contenders, criteria and cases a figure shows."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from jtik.errors import ArgumentError, UnknownNameError
from jtik.geometry import Solid
from jtik.plotting.obstacles_in import obstacles_in
from jtik.problems import Case
from jtik.result.solution import Trace
from jtik.types import Array

if TYPE_CHECKING:
    from jtik.study.comparison import Comparison


class Selection(NamedTuple):
    """The case and the criteria that a figure shows.

    Attributes:
        criteria: label of the criteria.
        case: name of the case.
    """

    criteria: str
    case: str


def chosen_contenders(comparison: Comparison, contenders: Iterable[str] | None) -> tuple[str, ...]:
    """The contenders to draw, all by default. Raises UnknownNameError for an unknown label."""
    if contenders is None:
        return comparison.contenders
    names = (contenders,) if isinstance(contenders, str) else tuple(contenders)
    for name in names:
        if name not in comparison.contenders:
            raise UnknownNameError("contender", name, comparison.contenders)
    return names


def chosen_criteria(comparison: Comparison, criteria: str | None) -> str:
    """The label of the criteria to draw, the first by default. Raises UnknownNameError for an unknown label."""
    if criteria is None:
        return comparison.criteria[0]
    if criteria not in comparison.criteria:
        raise UnknownNameError("criteria", criteria, comparison.criteria)
    return criteria


def recorded_cases(comparison: Comparison, kind: str | None = None) -> list[str]:
    """Names of the cases with recorded iterations or configurations, optionally of one kind.

    Raises:
        UnknownNameError: for an unknown kind.
        ArgumentError: if nothing was recorded.
    """
    if kind is not None and kind not in comparison.problems.kinds:
        raise UnknownNameError("kind", kind, comparison.problems.kinds)
    seen = {case for _, _, case in [*comparison.traces, *comparison.paths]}
    names = [case.name for case in comparison.problems if case.name in seen and kind in (None, case.kind)]
    if not names:
        raise ArgumentError("traces", "none recorded", "a study with compare(..., traces=1) or more")
    return names


def choose_case(comparison: Comparison, criteria: str | None, case: str | None) -> Selection:
    """A recorded case, the first by default. Raises UnknownNameError for a case that was not recorded."""
    names = recorded_cases(comparison)
    if case is not None and case not in names:
        raise UnknownNameError("case", case, names)
    return Selection(chosen_criteria(comparison, criteria), case or names[0])


def traces_of_case(comparison: Comparison, at: Selection, contenders: Iterable[str] | None) -> dict[str, Trace]:
    """The traces of a case by contender. Raises ArgumentError if there is none."""
    keys = {name: (name, at.criteria, at.case) for name in chosen_contenders(comparison, contenders)}
    found = {name: comparison.traces[key] for name, key in keys.items() if key in comparison.traces}
    if not found:
        raise ArgumentError("case", at.case, "a case with one target, solved by a strategy that records iterations")
    return found


def postures(comparison: Comparison, key: tuple[str, str, str]) -> Array | None:
    """Configurations along a path, or from the start that led to the answer to the answer, (k, nq).

    None if not recorded.
    """
    if key in comparison.paths:
        return np.asarray(comparison.paths[key])
    trace = comparison.traces.get(key)
    if trace is None:
        return None
    q = np.concatenate([trace.q[trace.answer_rows], trace.q[-1:]])
    turns = np.zeros(q.shape[1])
    revolute = comparison.robot.scalar_q[comparison.robot.rotational[comparison.robot.scalar_v]]
    turns[revolute] = np.round((q[-1] - q[-2])[revolute] / (2 * np.pi)) if len(q) > 1 else 0.0
    q[:-1] += 2 * np.pi * turns  # the last row is within the limits, which the others may be beyond by whole turns
    return np.asarray(q)


def configurations_of(comparison: Comparison, at: Selection, contenders: Iterable[str] | None) -> dict[str, Array]:
    """Configurations of each contender on a case, (k, nq). Raises ArgumentError if none were recorded."""
    pairs = ((name, postures(comparison, (name, *at))) for name in chosen_contenders(comparison, contenders))
    found = {name: q for name, q in pairs if q is not None}
    if not found:
        raise ArgumentError("case", at.case, "a recorded case; compare(..., traces=) sets their number")
    return found


def obstacles_of_case(comparison: Comparison, at: Selection) -> tuple[Solid, ...]:
    """The obstacles of the criteria and clearances on a case."""
    return obstacles_in({**comparison.obstacles.get(at.criteria, {}), **case_named(comparison, at.case).parameters})


def case_named(comparison: Comparison, name: str) -> Case:
    """The case with a name."""
    return next(case for case in comparison.problems if case.name == name)
