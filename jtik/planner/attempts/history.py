"""The attempts of a plan: a tree, each attempt below the one that it branched from."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, Self

from jtik.arguments import instances, number
from jtik.errors import ArgumentError, UnknownNameError
from jtik.planner.attempts.attempt import Attempt
from jtik.planner.files.plain import entries, inside, label

MOST_ATTEMPTS = 10_000
"""Largest number of attempts."""


@dataclass(frozen=True, eq=False, repr=False)
class History:
    """Immutable: every change gives another history, so that any thread may read one.

    Attributes:
        attempts: the attempts, each after its parent, in the order in which they were added.
        chosen: name of the attempt that was chosen; None for none.

    Raises:
        ArgumentError: for two attempts of one name, or a parent that is not among those before.
        UnknownNameError: when the chosen attempt does not exist.
    """

    attempts: tuple[Attempt, ...] = ()
    chosen: str | None = None

    def __post_init__(self) -> None:
        self._check("")

    def _check(self, where: str) -> None:
        attempts = instances(inside(where, "attempts"), self.attempts, Attempt, "attempts")
        object.__setattr__(self, "attempts", attempts)
        if len(attempts) > MOST_ATTEMPTS:
            raise ArgumentError(inside(where, "attempts"), f"{len(attempts)} attempts", f"at most {MOST_ATTEMPTS}")
        name, count = next(iter(Counter(attempt.name for attempt in attempts).most_common(1)), ("", 0))
        if count > 1:
            raise ArgumentError(
                inside(where, "attempts"), f"{count} with the name {name!r}", "a name of its own for each"
            )
        earlier: set[str] = set()
        for i, attempt in enumerate(attempts):
            if attempt.parent is not None and attempt.parent not in earlier:
                accepted = "None, or the name of an attempt before it"
                raise ArgumentError(inside(where, f"attempts[{i}].parent"), repr(attempt.parent), accepted)
            earlier.add(attempt.name)
        if self.chosen is not None and self.chosen not in earlier:
            raise UnknownNameError("attempt", str(self.chosen), earlier)

    def __len__(self) -> int:
        return len(self.attempts)

    def __iter__(self) -> Iterator[Attempt]:
        return iter(self.attempts)

    def __contains__(self, name: object) -> bool:
        return any(attempt.name == name for attempt in self.attempts)

    def __getitem__(self, name: str) -> Attempt:
        """The attempt of a name. Raises UnknownNameError for another."""
        for attempt in self.attempts:
            if attempt.name == name:
                return attempt
        raise UnknownNameError("attempt", str(name), self.names)

    def __repr__(self) -> str:
        return f"History({len(self)} attempts, chosen {self.chosen!r})"

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the attempts."""
        return tuple(attempt.name for attempt in self.attempts)

    def children(self, name: str | None) -> tuple[Attempt, ...]:
        """The attempts whose parent is the one of this name; those without a parent for None."""
        return tuple(attempt for attempt in self.attempts if attempt.parent == name)

    def free_name(self, parent: str | None = None) -> str:
        """A name that is not taken: "attempt 1", "attempt 2"; below a parent "attempt 2.1", "attempt 2.2"."""
        prefix, taken, number_ = f"{parent}." if parent else "attempt ", set(self.names), 1
        while f"{prefix}{number_}" in taken:
            number_ += 1
        return f"{prefix}{number_}"

    def add(self, attempt: Attempt) -> Self:
        """The history with one more attempt. Raises ArgumentError for a name that is taken or an unknown parent."""
        return replace(self, attempts=(*self.attempts, attempt))

    def branch(self, name: str, time: float, *, new_name: str | None = None) -> Attempt:
        """The beginning of an attempt that leaves another one at a time; it is not added.

        Args:
            name: the attempt that it leaves, which stays as it is.
            time: when it leaves it [s].
            new_name: its name; by default a free one.

        Raises:
            ArgumentError: for a time that is not in the attempt.
            UnknownNameError: when there is no such attempt.
        """
        parent = self[name]
        time = number("time", time, f"a time from 0 to {parent.duration:g} s", minimum=0.0)
        if time > parent.duration:
            raise ArgumentError("time", time, f"a time from 0 to {parent.duration:g} s")
        beginning = parent.cut(time)
        own = self.free_name(name) if new_name is None else new_name
        return replace(beginning, name=own, parent=name, branched_at=beginning.duration)

    def choose(self, name: str | None) -> Self:
        """The history with another attempt chosen; None for none. Raises UnknownNameError where it does not exist."""
        return replace(self, chosen=None if name is None else self[name].name)

    def rename(self, name: str, new_name: str) -> Self:
        """The history with another name for an attempt. Raises ArgumentError for a name that is taken."""
        self[name]
        renamed = [replace(each, name=new_name) if each.name == name else each for each in self.attempts]
        renamed = [replace(each, parent=new_name) if each.parent == name else each for each in renamed]
        return replace(self, attempts=tuple(renamed), chosen=new_name if self.chosen == name else self.chosen)

    def delete(self, name: str) -> Self:
        """The history without an attempt; those that branched from it move below its parent.

        Raises:
            UnknownNameError: when there is no such attempt.
        """
        gone = self[name]
        kept = [_without(each, gone) for each in self.attempts if each is not gone]
        return replace(self, attempts=tuple(kept), chosen=None if self.chosen == name else self.chosen)

    def to_json(self) -> dict[str, Any]:
        """Plain data of which `from_json` makes the same history."""
        return {"attempts": [attempt.to_json() for attempt in self.attempts], "chosen": self.chosen}

    @classmethod
    def from_json(cls, data: object, where: str = "history") -> Self:
        """The history of `to_json`.

        Args:
            data: plain data.
            where: where the data is, such as a file, for messages.

        Raises:
            ArgumentError: for anything else, naming the place and the key.
        """
        found = entries(where, data, ("attempts", "chosen"))
        given = found["attempts"]
        if not isinstance(given, list):
            raise ArgumentError(inside(where, "attempts"), given, "a list of attempts")
        attempts = tuple(Attempt.from_json(each, inside(where, f"attempts[{i}]")) for i, each in enumerate(given))
        chosen = None if found["chosen"] is None else label(inside(where, "chosen"), found["chosen"])
        if chosen is not None and chosen not in {attempt.name for attempt in attempts}:
            raise ArgumentError(inside(where, "chosen"), repr(chosen), "null, or the name of an attempt")
        made = object.__new__(cls)
        object.__setattr__(made, "attempts", attempts)
        object.__setattr__(made, "chosen", chosen)
        made._check(where)
        return made


def _without(attempt: Attempt, gone: Attempt) -> Attempt:
    """The attempt below the parent of one that goes."""
    if attempt.parent != gone.name:
        return attempt
    shared = None if None in (attempt.branched_at, gone.branched_at) else (attempt.branched_at, gone.branched_at)
    branched_at = None if shared is None or gone.parent is None else min(shared)  # type: ignore[type-var]
    return replace(attempt, parent=gone.parent, branched_at=branched_at)
