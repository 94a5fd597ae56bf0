"""The pairs of a robot's bodies that can touch, and the pairs that are left out, with the reason."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, TypeAlias

from jtik.arguments import several
from jtik.errors import ArgumentError, UnknownNameError
from jtik.robot.collisions.bodies import CollisionBody

PairNames: TypeAlias = Iterable[str | tuple[str, ...]]
"""Pairs by name: two names of frames or bodies each, or one name for all pairs with it."""

ACCEPTED = "pairs of names of frames or bodies, such as [('hand', 'link5')], or names for all pairs with one"


def pair_names(argument: str, given: object) -> tuple[tuple[str, ...], ...]:
    """The argument ``exclude`` or ``include``: one or two names each. Raises ArgumentError for anything else."""
    found = []
    for entry in several(argument, given, ACCEPTED, ordered=False):
        names = (entry,) if isinstance(entry, str) else entry
        if not isinstance(names, (tuple, list)) or len(names) not in (1, 2):
            raise ArgumentError(argument, entry, ACCEPTED)
        if not all(isinstance(name, str) for name in names):
            raise ArgumentError(argument, entry, ACCEPTED)
        if len(names) == 2 and names[0] == names[1]:
            raise ArgumentError(argument, entry, f"two different bodies in a pair; [{names[0]!r}] is all its pairs")
        found.append(tuple(names))
    return tuple(found)


@dataclass(frozen=True)
class CollisionPair:
    """Two bodies of a robot.

    Attributes:
        first: name of one.
        second: name of the other.
        left_out: why the pair is left out; None for a pair that is kept.
        at_home: their signed distance at the home configuration [m]; NaN where it was not measured.
        smallest: their smallest signed distance in the sample [m]; NaN where it was not measured.
        touching: share of the sample at which they touch; NaN where it was not measured.
    """

    first: str
    second: str
    left_out: str | None = None
    at_home: float = math.nan
    smallest: float = math.nan
    touching: float = math.nan

    @property
    def name(self) -> str:
        """Both names."""
        return f"{self.first} and {self.second}"


@dataclass(frozen=True, eq=False)
class CollisionPairs(Sequence[CollisionPair]):
    """The pairs of bodies that can touch: a sequence of `CollisionPair`. It prints as a table.

    Attributes:
        bodies: the bodies, by name.
        kept: the pairs that can touch, in the order of the bodies.
        left_out: the other pairs, with the reason, in the same order.
    """

    bodies: dict[str, CollisionBody]
    kept: tuple[CollisionPair, ...]
    left_out: tuple[CollisionPair, ...]

    def __len__(self) -> int:
        return len(self.kept)

    def __getitem__(self, index: Any) -> Any:
        return self.kept[index]

    def __iter__(self) -> Iterator[CollisionPair]:
        return iter(self.kept)

    def __repr__(self) -> str:
        return f"CollisionPairs({len(self.kept)} kept, {len(self.left_out)} left out)"

    def __str__(self) -> str:
        heads = ("pairs that can touch", "at home [m]", "smallest [m]", "touching")
        rows = [
            (pair.name, *(_number(each) for each in (pair.at_home, pair.smallest)), _share(pair.touching))
            for pair in self.kept
        ]
        width = [max(len(row[i]) for row in [heads, *rows]) for i in range(4)]
        lines = [
            "  ".join([row[0].ljust(width[0]), *(row[i].rjust(width[i]) for i in (1, 2, 3))]) for row in [heads, *rows]
        ]
        reasons = dict.fromkeys(str(pair.left_out) for pair in self.left_out)
        for reason in reasons:
            names = [pair.name for pair in self.left_out if pair.left_out == reason]
            lines.append(f"left out, {reason} ({len(names)}): {', '.join(names)}")
        return "\n".join(lines)

    def changed(self, exclude: PairNames, include: PairNames) -> CollisionPairs:
        """The same pairs with some left out and others kept, by name.

        Args:
            exclude: names, or pairs of names, of frames or bodies whose pairs are left out.
            include: the same for pairs that are kept.

        Raises:
            ArgumentError: when an entry is no name and no pair of names, or a pair is in both.
            UnknownNameError: when there is no frame or body of that name with a solid.
        """
        out, kept = (self._named(name, given) for name, given in (("exclude", exclude), ("include", include)))
        contradictory = [pair.name for i, pair in enumerate(self._all) if i in out & kept]
        if contradictory:
            raise ArgumentError("include", contradictory, "pairs that exclude does not name")
        pairs = [
            replace(pair, left_out="excluded" if i in out else None if i in kept else pair.left_out)
            for i, pair in enumerate(self._all)
        ]
        return CollisionPairs(
            self.bodies,
            tuple(pair for pair in pairs if pair.left_out is None),
            tuple(pair for pair in pairs if pair.left_out is not None),
        )

    @cached_property
    def _all(self) -> tuple[CollisionPair, ...]:
        order = {name: i for i, name in enumerate(self.bodies)}
        return tuple(sorted((*self.kept, *self.left_out), key=lambda pair: (order[pair.first], order[pair.second])))

    def _named(self, argument: str, given: PairNames) -> set[int]:
        """The indices in `_all` of the pairs that names mean."""
        chosen: set[int] = set()
        for names in pair_names(argument, given):
            sides = [self._bodies(name) for name in names]
            meant = set[int]()
            for i, pair in enumerate(self._all):
                ends = (pair.first, pair.second)
                if any(a in sides[0] and b in sides[-1] for a, b in (ends, ends[::-1])) or (
                    len(sides) == 1 and any(end in sides[0] for end in ends)
                ):
                    meant.add(i)
            if len(sides) == 2 and not meant:
                raise ArgumentError(argument, names, "the names of two bodies on different frames")
            chosen |= meant
        return chosen

    def _bodies(self, name: str) -> set[str]:
        """The names of the bodies that a name means."""
        found = {body.name for body in self.bodies.values() if name in body.names}
        if not found:
            known = dict.fromkeys(each for body in self.bodies.values() for each in reversed(body.names))
            raise UnknownNameError("body", name, known)
        return found


def _number(value: float) -> str:
    return "" if math.isnan(value) else f"{value:.3f}"


def _share(value: float) -> str:
    return "" if math.isnan(value) else f"{100 * value:.0f} %"
