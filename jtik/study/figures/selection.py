"""Which contenders, criteria and cases a figure shows."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from jtik.errors import ArgumentError, UnknownNameError
from jtik.problems import Case
from jtik.result.solution import Trace
from jtik.types import Array

if TYPE_CHECKING:
    from jtik.study.comparison import Comparison


class Selection(NamedTuple):
    """Which case of which criteria a figure shows."""

    criteria: str
    case: str


def chosen_contenders(comparison: Comparison, contenders: Iterable[str] | None) -> tuple[str, ...]:
    """The contenders to draw, all by default. Raises UnknownNameError for one that took no part."""
    if contenders is None:
        return comparison.contenders
    names = (contenders,) if isinstance(contenders, str) else tuple(contenders)
    for name in names:
        if name not in comparison.contenders:
            raise UnknownNameError("contender", name, comparison.contenders)
    return names


def chosen_criteria(comparison: Comparison, criteria: str | None) -> str:
    """The label of the criteria to draw, the first by default. Raises UnknownNameError for another."""
    if criteria is None:
        return comparison.criteria[0]
    if criteria not in comparison.criteria:
        raise UnknownNameError("criteria", criteria, comparison.criteria)
    return criteria


def recorded_cases(comparison: Comparison, kind: str | None = None) -> list[str]:
    """Names of the cases whose iterations or postures the study kept, perhaps of one kind.

    Raises:
        UnknownNameError: for a kind that the study has not.
        ArgumentError: when there are none.
    """
    if kind is not None and kind not in comparison.problems.kinds:
        raise UnknownNameError("kind", kind, comparison.problems.kinds)
    seen = {case for _, _, case in [*comparison.traces, *comparison.paths]}
    names = [case.name for case in comparison.problems if case.name in seen and kind in (None, case.kind)]
    if not names:
        raise ArgumentError("traces", "none kept", "a study with compare(..., traces=1) or more")
    return names


def choose_case(comparison: Comparison, criteria: str | None, case: str | None) -> Selection:
    """One case, the first that was kept by default. Raises UnknownNameError for one that was not."""
    names = recorded_cases(comparison)
    if case is not None and case not in names:
        raise UnknownNameError("case", case, names)
    return Selection(chosen_criteria(comparison, criteria), case or names[0])


def traces_of_case(comparison: Comparison, at: Selection, contenders: Iterable[str] | None) -> dict[str, Trace]:
    """The iterations on a case, of the contenders that have them. Raises ArgumentError when none has."""
    keys = {name: (name, at.criteria, at.case) for name in chosen_contenders(comparison, contenders)}
    found = {name: comparison.traces[key] for name, key in keys.items() if key in comparison.traces}
    if not found:
        raise ArgumentError("case", at.case, "a case of one target, solved by strategies that tell their iterations")
    return found


def postures(comparison: Comparison, key: tuple[str, str, str]) -> Array | None:
    """Configurations along a path, or from the start to the answer, (k, nq); None where they were not kept."""
    if key in comparison.paths:
        return np.asarray(comparison.paths[key])
    trace = comparison.traces.get(key)
    return None if trace is None else np.asarray(trace.q)


def configurations_of(comparison: Comparison, at: Selection, contenders: Iterable[str] | None) -> dict[str, Array]:
    """Configurations of each contender on a case, (k, nq). Raises ArgumentError when none were kept."""
    pairs = ((name, postures(comparison, (name, *at))) for name in chosen_contenders(comparison, contenders))
    found = {name: q for name, q in pairs if q is not None}
    if not found:
        raise ArgumentError("case", at.case, "a case whose postures were kept: compare(..., traces=)")
    return found


def case_named(comparison: Comparison, name: str) -> Case:
    """The case of that name."""
    return next(case for case in comparison.problems if case.name == name)
