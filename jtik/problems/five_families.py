"""Five families of problems for an arm of ten unit links, and one unreachable family: the table of papers/das1988.

The families are those of the study behind `Das, Slotine and Sheridan 1988 <papers/das1988>`: generic, far and nearly
straight starts, with targets inside, at the boundary of and beyond the workspace.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from jtik.arguments import positive_integer, text
from jtik.errors import UnknownNameError
from jtik.problems.case import Case, ProblemSet, case_name
from jtik.types import Array

LINKS = 10
"""Number of links of the arm, each 1 m long."""

SEED = 1988
"""Seed of the published problems."""

Drawn = tuple[Array, Array]
"""Start (10,) [rad] and target (2,) [m]."""


def tip(q: Array) -> Array:
    """Tip position of an arm of unit links at q [m], in closed form."""
    angle = np.cumsum(q)
    return np.array([np.cos(angle).sum(), np.sin(angle).sum()])


def _around(radius: float, generator: np.random.Generator) -> Array:
    """A point at distance ``radius`` from the base in a random direction [m]."""
    direction = generator.uniform(-np.pi, np.pi)
    return radius * np.array([np.cos(direction), np.sin(direction)])


def anywhere(spread: float) -> Callable[[np.random.Generator], Drawn]:
    """Start and goal configuration uniform in (-spread, spread); the target is the tip position at the goal."""
    return lambda drawn: (drawn.uniform(-spread, spread, LINKS), tip(drawn.uniform(-spread, spread, LINKS)))


def straight(deviation: float) -> Callable[[np.random.Generator], Drawn]:
    """Joint angles normal with standard deviation ``deviation``; the target on the x axis between 3 and 9 m."""
    return lambda drawn: (deviation * drawn.standard_normal(LINKS), np.array([drawn.uniform(3, 9), 0.0]))


def ring(radius: float) -> Callable[[np.random.Generator], Drawn]:
    """A start uniform in (-1, 1); the target at distance ``radius`` from the base in a random direction."""
    return lambda drawn: (drawn.uniform(-1, 1, LINKS), _around(radius, drawn))


FAMILIES: dict[str, Callable[[np.random.Generator], Drawn]] = {
    "generic": anywhere(1.0),
    "far": anywhere(np.pi),
    "near-straight 1e-3": straight(1e-3),
    "near-straight 1e-6": straight(1e-6),
    "boundary 9.999": ring(9.999),
    "unreachable 10.5": ring(10.5),
}
"""Generator of start and target by family; only the last family is unreachable."""

SMALLEST_ERROR = {"unreachable 10.5": 0.5}
"""Smallest possible error of a family [m]; 0 for the others."""


def family(name: str, count: int = 200) -> ProblemSet:
    """The first ``count`` problems of a family, which do not depend on count.

    Raises:
        UnknownNameError: for an unknown family.
        ArgumentError: unless count is a positive integer.
    """
    if text("name", name, "the name of a family") not in FAMILIES:
        raise UnknownNameError("family", name, FAMILIES)
    count = positive_integer("count", count)
    place, error = list(FAMILIES).index(name), SMALLEST_ERROR.get(name, 0.0)
    origin = "five families of ten unit links, papers/das1988"
    cases = []
    for index in range(count):
        q0, target = FAMILIES[name](np.random.default_rng([SEED, place, index]))
        cases.append(
            Case(
                name=case_name(name, index),
                kind=name,
                q0=q0,
                targets=(target,),
                reachable=error == 0,
                known={"error": error},
                origin=origin,
            )
        )
    return ProblemSet(name, tuple(cases), SEED, origin)


def five_families(count: int = 200) -> ProblemSet:
    """``count`` problems of each family, for ``Robot.planar(10)`` and a position task of its tip.

    Raises:
        ArgumentError: unless count is a positive integer.
    """
    cases = tuple(case for name in FAMILIES for case in family(name, count))
    return ProblemSet("five families", cases, SEED, cases[0].origin)
