"""Statements of generated C, what they read and set, and blocks of them that are alike."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

REPEATED = 64
"""Blocks of statements that are alike, from which on they are a loop: for fewer it is slower."""

LONGEST_BLOCK = 40
"""Most statements of a block."""


class Value(NamedTuple):
    """What a statement computes.

    Attributes:
        statement: number of the statement.
        variable: the variable that it sets.
    """

    statement: int
    variable: str

    def __str__(self) -> str:
        return self.variable


class Entry(NamedTuple):
    """An entry of an array.

    Attributes:
        array: name of the array.
        place: which entry; in a loop that of the first pass.
        stride: how much further it is in each pass of a loop.
    """

    array: str
    place: int
    stride: int = 0

    def __str__(self) -> str:
        further = {0: "", 1: "+i"}.get(self.stride, f"+{self.stride}*i")
        return f"{self.array}[{self.place}{further}]"

    def at(self, count: int) -> Entry:
        """That of a pass of a loop.

        Args:
            count: number of passes before it.
        """
        return Entry(self.array, self.place + self.stride * count)


class Own(NamedTuple):
    """What a statement of the same pass of a loop computes.

    Attributes:
        offset: number of the statement in the block.
    """

    offset: int

    def __str__(self) -> str:
        return f"b{self.offset}"


class Carried(NamedTuple):
    """What a statement of the pass before computes.

    Attributes:
        offset: number of the statement in the block.
        first: what is read instead in the first pass.
    """

    offset: int
    first: Value | Entry | str


Operand = Value | Entry | str
"""What a statement reads; a text is the name of a variable."""


@dataclass(frozen=True)
class Statement:
    """A statement.

    Attributes:
        texts: the text before, between and after what it names; of a call all of its text.
        target: what it sets; None for a call.
        operands: what it reads.
        kind: equal for statements that differ in variables and entries alone.
    """

    texts: Sequence[str]
    target: Value | Entry | None
    operands: Sequence[Operand]
    kind: str

    @property
    def places(self) -> list[int]:
        """The entries of arrays, and the statements that compute a value, of all that it names."""
        named = [each for each in [self.target, *self.operands] if not isinstance(each, (str, type(None)))]
        return [each.place if isinstance(each, Entry) else each.statement for each in named]

    def text(self, target: object, operands: Sequence[object]) -> str:
        """The statement with other names.

        Args:
            target: what it sets.
            operands: what it reads.
        """
        names = [] if self.target is None else [target, *operands]
        return self.texts[0] + "".join(f"{name}{text}" for name, text in zip(names, self.texts[1:], strict=True))


@dataclass(frozen=True)
class Loop:
    """Blocks of statements that are alike.

    Attributes:
        start: the first statement.
        count: number of blocks.
        targets: what each statement of a block sets; None for a variable.
        operands: what each reads.
    """

    start: int
    count: int
    targets: Sequence[Entry | None]
    operands: Sequence[Sequence[Operand | Own | Carried]]

    @property
    def end(self) -> int:
        """The statement after it."""
        return self.start + len(self.targets) * self.count

    @property
    def arrays(self) -> set[str]:
        """The arrays whose entries are read or written."""
        named = [each for own in [self.targets, *self.operands] for each in own]
        return {each.array for each in named if isinstance(each, Entry)}

    @property
    def carries(self) -> int:
        """How many values each pass hands to the next."""
        return len({each for own in self.operands for each in own if isinstance(each, Carried)})

    @property
    def carrying(self) -> set[int]:
        """The statements that depend on the pass before."""
        found = set[int]()
        for offset, operands in enumerate(self.operands):
            if any(isinstance(each, Carried) or (isinstance(each, Own) and each.offset in found) for each in operands):
                found.add(offset)
        return found

    def read_by(self, part: Sequence[int]) -> list[int]:
        """The other statements whose values some statements read.

        Args:
            part: the statements that read.
        """
        read = {each.offset for k in part for each in self.operands[k] if isinstance(each, (Own, Carried))}
        return sorted(read.difference(part))


def repeating(kinds: Sequence[str], places: Sequence[Sequence[int]] | None = None) -> dict[int, dict[int, int]]:
    """Where blocks may repeat: by their first statement, and their size, how many at most.

    Args:
        kinds: the kind of each statement, the same in all blocks.
        places: the `Statement.places` of each, which change by the same amounts from block to block; what is carried
            into the first block excepted. None where they are not known.
    """
    numbers, found = dict[str, int](), dict[int, dict[int, int]]()
    known = np.array([numbers.setdefault(kind, len(numbers)) for kind in kinds])
    at = np.zeros((len(kinds), max(map(len, places), default=0) if places else 0), dtype=int)
    for row, own in enumerate(places or ()):
        at[row, : len(own)] = own
    for size in range(1, min(LONGEST_BLOCK, len(known) // REPEATED) + 1):
        starts = np.arange(len(known) - size * REPEATED + 1)
        blocks = _run(known[size:] == known[:-size], starts) // size + 1
        even = (at[2 * size :] - 2 * at[size:-size] + at[: -2 * size] == 0).all(axis=1)
        blocks = np.minimum(blocks, _run(even, starts + size) // size + 3)
        for start in np.flatnonzero(blocks >= REPEATED).tolist():
            found.setdefault(start, {})[size] = int(blocks[start])
    return found


def _run(truth: NDArray[np.bool_], starts: NDArray[np.intp]) -> NDArray[np.intp]:
    """How many entries are true from each start on."""
    ends = np.append(np.flatnonzero(~truth), len(truth))
    found: NDArray[np.intp] = ends[np.searchsorted(ends, starts)] - starts
    return found


def covered(blocks: Mapping[int, Mapping[int, int]], count: int) -> int:
    """How many statements at most are in blocks that repeat.

    Args:
        blocks: as `repeating` finds them.
        count: number of all statements.
    """
    begins = np.zeros(count + 1, dtype=int)
    for start, sizes in blocks.items():
        begins[start] += 1
        begins[start + max(size * alike for size, alike in sizes.items())] -= 1
    return int(np.count_nonzero(np.cumsum(begins) > 0))


def entry(text: str) -> Entry:
    """The entry of an array that a text is.

    Args:
        text: such as ``x0[3]``.
    """
    array, place = text[:-1].split("[")
    return Entry(array, int(place))


def alike(a: Operand, b: Operand, start: int, size: int) -> Operand | Own | Carried | None:
    """What both operands are in the first two passes of a loop; None where they are not alike.

    Args:
        a: the operand in the first block.
        b: the same in the second one.
        start: the first statement.
        size: number of statements of a block.
    """
    inside = isinstance(a, Value) and a.statement >= start
    if isinstance(b, Value) and b.statement >= start:
        if b.statement < start + size:
            return None if inside else Carried(b.statement - start, a)
        return Own(b.statement - start - size) if inside and b.statement == a.statement + size else None  # type: ignore[union-attr]
    if isinstance(a, Entry) and isinstance(b, Entry):
        return a._replace(stride=b.place - a.place) if a.array == b.array else None
    return a if a == b else None
