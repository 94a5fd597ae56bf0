"""The problems of a study, from whatever a caller names them by."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from jtik import problems as generators
from jtik.errors import ArgumentError, UnknownNameError
from jtik.problems import Case, ProblemSet
from jtik.study.contender import Setting
from jtik.study.ruler import NamedMeasure

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
"""The kinds of problems that are drawn by name."""


def problems_of(given: Any, setting: Setting, measures: Iterable[NamedMeasure], *, count: int, seed: int) -> ProblemSet:
    """The problems: those given, or drawn for the setting.

    Args:
        given: a ProblemSet, cases, the name of a kind, several, or a mapping from kind to count.
        setting: robot and task.
        measures: what tells distances to obstacles: scenes are drawn for them.
        count: how many of each kind.
        seed: of the random numbers.

    Raises:
        ArgumentError: for none, or what cannot be drawn.
        UnknownNameError: for a kind that nobody draws.
    """
    if isinstance(given, ProblemSet):
        found = given
    elif isinstance(given, Case):
        found = ProblemSet(given.name, (given,))
    elif isinstance(given, str):
        found = _drawn({given: count}, setting, measures, seed)
    elif isinstance(given, Mapping):
        found = _drawn(given, setting, measures, seed)
    elif isinstance(given, Iterable):
        several = list(given)
        if several and all(isinstance(each, Case) for each in several):
            found = ProblemSet("problems", tuple(several))
        elif several and all(isinstance(each, str) for each in several):
            found = _drawn(dict.fromkeys(several, count), setting, measures, seed)
        else:
            raise ArgumentError("problems", given, _ACCEPTED)
    else:
        raise ArgumentError("problems", given, _ACCEPTED)
    if not len(found):
        raise ArgumentError("problems", given, "at least one case")
    return found


_ACCEPTED = f"a jtik.problems.ProblemSet, cases, or kinds from {', '.join(KINDS)}, perhaps with counts: {{kind: count}}"


def _drawn(counts: Mapping[str, int], setting: Setting, measures: Iterable[NamedMeasure], seed: int) -> ProblemSet:
    for kind in counts:
        if kind not in KINDS:
            raise UnknownNameError("kind of problems", kind, KINDS)
    if not counts:
        raise ArgumentError("problems", counts, _ACCEPTED)
    sets = []
    for kind, count in counts.items():
        options = _scenery(setting, measures) if kind == "scene" else {}
        sets.append(
            KINDS[kind](setting.robot, setting.task, count, seed=seed, joints=setting.joints, at=setting.at, **options)
        )
    first, *others = sets
    for other in others:
        first = first + other
    return first


def _scenery(setting: Setting, measures: Iterable[NamedMeasure]) -> dict[str, Any]:
    """How many obstacles a scene must have, and whose centres they are."""
    robot, _ = setting.reduced()
    counts = {}
    for each in measures:
        centers = each.parameters(robot).get("centers")
        if centers is not None:
            counts[each.name] = int(np.shape(centers)[0])
    if not counts:
        accepted = "criteria or clearances that measure distances to obstacles, such as ObstacleAvoidance(...)"
        raise ArgumentError("problems", "scenes without anything that could see them", accepted)
    return {"obstacles": max(counts.values()), "criteria": list(counts)}
