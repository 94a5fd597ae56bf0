"""Names and slices of a vector: of the state of a step, and of the record of its figures."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeVar

from jtik.symbolic import Expression, vertcat

Value = TypeVar("Value")


@dataclass(frozen=True)
class VectorLayout:
    """Where the named parts of a vector are.

    Attributes:
        slices: slice of each part, by name, one after the other.
        size: number of entries of the vector.
    """

    slices: Mapping[str, slice]
    size: int

    @classmethod
    def of(cls, sizes: Mapping[str, int]) -> VectorLayout:
        """The layout of parts of these sizes, one after the other."""
        slices, start = {}, 0
        for name, size in sizes.items():
            slices[name] = slice(start, start + size)
            start += size
        return cls(slices, start)

    @staticmethod
    def united(*groups: Mapping[str, Value]) -> dict[str, Value]:
        """The parts of all groups, one group after the other.

        Raises:
            ValueError: when two groups have a part of the same name, so that one would overwrite the other.
        """
        united: dict[str, Value] = {}
        for group in groups:
            if twice := united.keys() & group.keys():
                raise ValueError(f"Two groups of parts have the names {sorted(twice)}.")
            united |= group
        return united

    def split(self, column: Expression) -> dict[str, Expression]:
        """The named parts of a column."""
        return {name: column[where] for name, where in self.slices.items()}

    def join(self, parts: Mapping[str, Expression]) -> Expression:
        """The column of named parts."""
        return vertcat(*[parts[name] for name in self.slices])
