"""Selection of the problems of a study: given cases, or kinds of problems to draw."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from jtik import problems as generators
from jtik.arguments import positive_integer, several
from jtik.errors import ArgumentError, UnknownNameError
from jtik.problems import Case, ProblemSet
from jtik.study.contender import Setting
from jtik.study.metrics import NamedMeasure

KINDS: Mapping[str, Callable[..., ProblemSet]] = {
    name: getattr(generators, name)
    for name in (
        "reachable",
        "near_singular",
        "boundary",
        "unreachable",
        "near_limits",
        "circle",
        "line",
        "lissajous",
        "scene",
    )
}
"""Generators by the kind of problems that they draw."""


def select_problems(
    given: Any, setting: Setting, measures: Iterable[NamedMeasure], *, count: int, seed: int
) -> ProblemSet:
    """The problems of a study, as given or drawn for its setting.

    Args:
        given: a ProblemSet, one case or several, one kind or several, or a mapping from kind to count.
        setting: robot and task.
        measures: measures of distances to obstacles, for which scenes are drawn.
        count: number of cases of each kind.
        seed: seed of the random numbers.

    Raises:
        ArgumentError: for no problem, or problems that cannot be drawn.
        UnknownNameError: for an unknown kind.
    """
    count = positive_integer("count", count)
    if isinstance(given, ProblemSet):
        selected = given
    elif isinstance(given, Case):
        selected = ProblemSet(given.name, (given,))
    elif isinstance(given, str):
        selected = _drawn({given: count}, setting, measures, seed)
    elif isinstance(given, Mapping):
        selected = _drawn(given, setting, measures, seed)
    else:
        chosen = several("problems", given, _ACCEPTED)
        if chosen and all(isinstance(each, Case) for each in chosen):
            selected = ProblemSet("problems", chosen)
        elif chosen and all(isinstance(each, str) for each in chosen):
            selected = _drawn(dict.fromkeys(chosen, count), setting, measures, seed)
        else:
            raise ArgumentError("problems", given, _ACCEPTED)
    if not len(selected):
        raise ArgumentError("problems", given, "at least one case")
    return selected


_ACCEPTED = (
    f"a jtik.problems.ProblemSet, cases, or kinds from {', '.join(KINDS)}, optionally with counts: {{kind: count}}"
)


def _drawn(counts: Mapping[str, int], setting: Setting, measures: Iterable[NamedMeasure], seed: int) -> ProblemSet:
    for kind in counts:
        if kind not in KINDS:
            raise UnknownNameError("kind of problems", kind, KINDS)
    if not counts:
        raise ArgumentError("problems", counts, _ACCEPTED)
    sets = []
    for kind, count in counts.items():
        options = _obstacle_options(setting, measures) if kind == "scene" else {}
        sets.append(
            KINDS[kind](setting.robot, setting.task, count, seed=seed, joints=setting.joints, at=setting.at, **options)
        )
    first, *others = sets
    for other in others:
        first = first + other
    return first


def _obstacle_options(setting: Setting, measures: Iterable[NamedMeasure]) -> dict[str, Any]:
    """The number of obstacles of a scene, and the criteria whose centres it sets."""
    robot, _ = setting.reduced()
    counts = {}
    for each in measures:
        centers = each.parameters(robot).get("centers")
        if centers is not None:
            counts[each.name] = int(np.shape(centers)[0])
    if not counts:
        accepted = "criteria or clearances that measure distances to obstacles, such as ObstacleAvoidance(...)"
        raise ArgumentError("problems", "scenes without a criterion or clearance for their obstacles", accepted)
    return {"obstacles": max(counts.values()), "criteria": list(counts)}
