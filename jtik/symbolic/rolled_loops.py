"""Statements of generated C that repeat with other entries of the same arrays, as loops.

A function of scalar operations has a statement for each operation of each row of a matrix. Where many rows follow one
another that are computed alike, here is one loop: a compiler takes a fraction of the time, the code is short, and
vector instructions can be used. What is computed, and in which order, stays the same, and so do all bits.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

REPEATED = 32
"""Blocks of statements that are alike, from which on they are a loop."""

LONGEST_BLOCK = 40
"""Most statements of a block."""

_OPERAND = re.compile(r"\b(a\d+|[xyw]\d*\[\d+\])(?!\w)")
_VARIABLE = re.compile(r"\ba\d+\b")
_LOAD = re.compile(r"^  a\d+=x\d+\[\d+\];$")


class Value(NamedTuple):
    """What a statement computes, in the variable that it sets."""

    statement: int
    variable: str

    def __str__(self) -> str:
        return self.variable


class Entry(NamedTuple):
    """An entry of an array, which is ``stride`` further in each pass of a loop."""

    array: str
    place: int
    stride: int = 0

    def __str__(self) -> str:
        further = {0: "", 1: "+i"}.get(self.stride, f"+{self.stride}*i")
        return f"{self.array}[{self.place}{further}]"

    def at(self, count: int) -> Entry:
        """That of a pass of a loop."""
        return Entry(self.array, self.place + self.stride * count)


class Own(NamedTuple):
    """What a statement of the same pass of a loop computes."""

    offset: int

    def __str__(self) -> str:
        return f"b{self.offset}"


class Carried(NamedTuple):
    """What a statement of the pass before computes, and another operand in the first pass."""

    offset: int
    first: Value | Entry | str


Operand = Value | Entry | str
"""What a statement reads; a text is the name of a variable."""


@dataclass(frozen=True)
class _Statement:
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

    def text(self, target: object, operands: Sequence[object]) -> str:
        """The statement with this target and these operands."""
        names = [] if self.target is None else [target, *operands]
        return self.texts[0] + "".join(f"{name}{text}" for name, text in zip(names, self.texts[1:], strict=True))


@dataclass(frozen=True)
class _Loop:
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


def rolled(lines: Sequence[str]) -> str | None:
    """The body of a function of scalar operations with loops, and its variables; None where nothing repeats.

    Args:
        lines: its statements, in which inputs are ``x`` and outputs ``y``.
    """
    body = _Body(lines)
    body.roll()
    if not body.has_loops:
        return None
    written = "\n".join(body.written)
    variables = ", ".join(dict.fromkeys(_VARIABLE.findall(written)))
    return "\n".join([*body.declared, *([f"  casadi_real {variables};"] if variables else []), written])


class _Body:
    """A body that is being written.

    Args:
        lines: the statements.

    Attributes:
        declared: declarations of what loops compute and later statements read.
        written: the lines.
        has_loops: whether there is a loop.
    """

    def __init__(self, lines: Sequence[str]) -> None:
        self.declared, self.written, self.has_loops = list[str](), list[str](), False
        self._statements = list[_Statement]()
        self._last = dict[int, int]()  # the last statement that reads what another one computes
        self._moved = dict[int, Operand]()  # where what loops compute is afterwards
        latest = dict[str, Value | Entry]()
        for line in lines:
            texts = _OPERAND.split(line)
            names, at = texts[1::2], len(self._statements)
            operands = [latest[name] if name in latest else _entry(name) for name in names[1:]]
            if _LOAD.match(line):  # what reads the variable reads the input
                latest[names[0]] = operands[0]
                continue
            for each in operands:
                if isinstance(each, Value):
                    self._last[each.statement] = at
            target = None if not names else _entry(names[0]) if "[" in names[0] else Value(at, names[0])
            kinds = [each.array if isinstance(each, Entry) else "" for each in [target, *operands]]
            kind = "\0".join([texts[0], *(f"{a}\0{b}" for a, b in zip(kinds, texts[2::2], strict=False))])
            self._statements.append(_Statement(texts[::2], target, operands, kind))
            if isinstance(target, Value):
                latest[target.variable] = target
        numbers = dict[str, int]()
        self._kinds = [numbers.setdefault(each.kind, len(numbers)) for each in self._statements]

    def roll(self) -> None:
        """Write all statements."""
        at = 0
        while at < len(self._statements):
            found = [loop for size in range(1, LONGEST_BLOCK + 1) if (loop := self._loop(at, size))]
            if found:
                loop = max(found, key=lambda loop: loop.end)
                self._write(loop)
                at = loop.end
            else:
                each = self._statements[at]
                self.written.append(each.text(each.target, [self._operand(operand) for operand in each.operands]))
                at += 1

    def _operand(self, operand: Operand) -> Operand:
        """An operand as it is known after the loops before."""
        return self._moved.get(operand.statement, operand) if isinstance(operand, Value) else operand

    def _loop(self, start: int, size: int) -> _Loop | None:
        """The longest loop from a statement on with blocks of this size; None where they do not repeat."""
        kinds, block = self._kinds, self._kinds[start : start + size]
        if len(kinds) < start + REPEATED * size or kinds[start + size : start + 2 * size] != block:
            return None
        first, second = (self._statements[start + k * size : start + (k + 1) * size] for k in range(2))
        targets, operands = list[Entry | None](), list[list[Operand | Own | Carried]]()
        for one, other in zip(first, second, strict=True):
            a, b = one.target, other.target
            if a is None:
                return None
            targets.append(
                a._replace(stride=b.place - a.place) if isinstance(a, Entry) and isinstance(b, Entry) else None
            )
            pairs = zip(map(self._operand, one.operands), map(self._operand, other.operands), strict=True)
            own = [_alike(a, b, start, size) for a, b in pairs]
            if None in own:
                return None
            operands.append(own)  # type: ignore[arg-type]
        count = 2
        while kinds[start + count * size : start + (count + 1) * size] == block:
            if not self._continues(_Loop(start, count, targets, operands)):
                break
            count += 1
        return _Loop(start, count, targets, operands) if count >= REPEATED else None

    def _continues(self, loop: _Loop) -> bool:
        """Whether the block after a loop belongs to it."""
        size = len(loop.targets)
        for offset, (target, operands) in enumerate(zip(loop.targets, loop.operands, strict=True)):
            each = self._statements[loop.end + offset]
            if target is not None and each.target != target.at(loop.count):
                return False
            for expected, operand in zip(operands, map(self._operand, each.operands), strict=True):
                if isinstance(expected, (Own, Carried)):
                    before = size if isinstance(expected, Carried) else 0
                    alike = isinstance(operand, Value) and operand.statement == loop.end + expected.offset - before
                elif isinstance(expected, Entry):
                    alike = operand == expected.at(loop.count)
                else:
                    alike = operand == expected
                if not alike:
                    return False
        return True

    def _write(self, loop: _Loop) -> None:
        number, size = len(self._moved) + len(self.written), len(loop.targets)
        self.has_loops = True
        begin, inside, after = list[str](), list[str](), list[str]()
        carried = dict[Carried, str]()
        for operand in (each for own in loop.operands for each in own):
            if isinstance(operand, Carried) and operand not in carried:
                name = carried[operand] = f"c{len(carried)}"
                begin.append(f"casadi_real {name} = {operand.first};")
                after.append(f"{name} = b{operand.offset};")
        for offset, (target, operands) in enumerate(zip(loop.targets, loop.operands, strict=True)):
            names = [carried[each] if isinstance(each, Carried) else each for each in operands]
            text = self._statements[loop.start + offset].text(target or Own(offset), names).strip()
            inside.append(text if target else f"const casadi_real {text}")
            values = range(loop.start + offset, loop.end, size)
            read = [k for k, value in enumerate(values) if self._last.get(value, 0) >= loop.end]
            if target or not read:
                continue
            name = f"t{number}_{offset}"
            if read == [loop.count - 1]:
                self.declared.append(f"  casadi_real {name};")
                after.append(f"{name} = b{offset};")
                self._moved[values[-1]] = name
            else:
                self.declared.append(f"  casadi_real {name}[{loop.count}];")
                after.append(f"{name}[i] = b{offset};")
                self._moved |= {values[k]: Entry(name, k) for k in read}
        arrays = [each.array for own in [loop.targets, *loop.operands] for each in own if isinstance(each, Entry)]
        independent = [] if carried or "w" in arrays else ["    JTIK_INDEPENDENT"]
        self.written += ["  {", "    casadi_int i;", *(f"    {line}" for line in begin), *independent]
        self.written += [f"    for (i=0; i<{loop.count}; ++i) {{", *(f"      {line}" for line in [*inside, *after])]
        self.written += ["    }", "  }"]


def _entry(text: str) -> Entry:
    """The entry of an array that a text is."""
    array, place = text[:-1].split("[")
    return Entry(array, int(place))


def _alike(a: Operand, b: Operand, start: int, size: int) -> Operand | Own | Carried | None:
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
