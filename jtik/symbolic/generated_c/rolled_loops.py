"""Statements of generated C that repeat with other entries of the same arrays, as loops.

A function of scalar operations has a statement for each operation of each row of a matrix. Where many rows follow one
another that are computed alike, here is one loop: a compiler takes a fraction of the time, the code is short, and
vector instructions can be used. What is computed, and in which order, stays the same, and so do all bits.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from jtik.symbolic.generated_c.repeated_statements import (
    REPEATED,
    Carried,
    Entry,
    Loop,
    Operand,
    Own,
    Statement,
    Value,
    alike,
    covered,
    entry,
    repeating,
)

MOST_KEPT = 32768
"""Most entries of arrays for what loops compute: they are on the stack of a thread."""

_OPERAND = re.compile(r"\b(a\d+|[xyw]\d*\[\d+\])(?!\w)")
_VARIABLE = re.compile(r"\ba\d+\b")
_DIGITS = re.compile(r"\d+")
_LOAD = re.compile(r"^  a\d+=x\d+\[\d+\];$")


def rolled(lines: Sequence[str], longest: int) -> str | None:
    """The body of a function of scalar operations with loops, and its variables; None where nothing repeats.

    Args:
        lines: its statements, in which inputs are ``x`` and outputs ``y``.
        longest: most lines; None is returned for a body that would be longer.
    """
    kinds = [_DIGITS.sub("", line) for line in lines if not _LOAD.match(line)]
    blocks = repeating(kinds)
    if not blocks or len(kinds) - covered(blocks, len(kinds)) > longest:
        return None
    body = _Body(lines)
    body.roll()
    if not body.has_loops or len(body.written) > longest or body.kept > MOST_KEPT:
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
        kept: entries of the arrays that are declared.
    """

    def __init__(self, lines: Sequence[str]) -> None:
        self.declared, self.written, self.has_loops, self.kept = list[str](), list[str](), False, 0
        self._statements = list[Statement]()
        self._last = dict[int, int]()  # the last statement that reads what another one computes
        self._moved = dict[int, Operand]()  # where what loops compute is afterwards
        latest = dict[str, Value | Entry]()
        for line in lines:
            texts = _OPERAND.split(line)
            names, at = texts[1::2], len(self._statements)
            operands = [latest[name] if name in latest else entry(name) for name in names[1:]]
            if _LOAD.match(line):  # what reads the variable reads the input
                latest[names[0]] = operands[0]
                continue
            for each in operands:
                if isinstance(each, Value):
                    self._last[each.statement] = at
            target = None if not names else entry(names[0]) if "[" in names[0] else Value(at, names[0])
            kinds = [each.array if isinstance(each, Entry) else "" for each in [target, *operands]]
            kind = "\0".join([texts[0], *(f"{a}\0{b}" for a, b in zip(kinds, texts[2::2], strict=False))])
            self._statements.append(Statement(texts[::2], target, operands, kind))
            if isinstance(target, Value):
                latest[target.variable] = target
        self._repeating = repeating(
            [each.kind for each in self._statements], [each.places for each in self._statements]
        )

    def roll(self) -> None:
        """Write all statements."""
        at = 0
        while at < len(self._statements):
            loop = self._longest(at)
            for each in self._statements[at : loop.start if loop else at + 1]:
                self.written.append(each.text(each.target, [self._operand(operand) for operand in each.operands]))
            if loop is not None:
                self._write(loop)
            at = loop.end if loop else at + 1

    def _longest(self, start: int) -> Loop | None:
        """The longest loop from a statement on, or from one soon after it where that carries less; None without any."""
        longest, sizes = None, list[int]()
        for size in self._repeating.get(start, ()):
            if any(size % each == 0 for each in sizes):  # several blocks of a loop that is known are no longer one
                continue
            loop = self._loop(start, size)
            if loop is not None:
                sizes.append(size)
                longest = loop if longest is None or longest.end < loop.end else longest
        if longest is None or not longest.carries:
            return longest
        size = len(longest.targets)
        later = [loop for k in range(1, size) if (loop := self._loop(start + k, size, shortest=2, longest=2))]
        best = min([longest, *later], key=lambda loop: loop.carries)
        later_one = self._loop(best.start, size)
        return later_one if later_one and later_one.end + size >= longest.end else longest

    def _operand(self, operand: Operand) -> Operand:
        """An operand as it is known after the loops before."""
        return self._moved.get(operand.statement, operand) if isinstance(operand, Value) else operand

    def _loop(self, start: int, size: int, shortest: int = REPEATED, longest: int | None = None) -> Loop | None:
        """The longest loop from a statement on with blocks of this size; None where they do not repeat.

        Args:
            start: the first statement.
            size: number of statements of a block.
            shortest: fewest blocks.
            longest: most blocks; None for no limit.
        """
        if size not in self._repeating.get(start, ()):
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
            own = [alike(a, b, start, size) for a, b in pairs]
            if None in own:
                return None
            operands.append(own)  # type: ignore[arg-type]
        count, most = 2, longest or self._repeating[start][size]
        while count < most and self._continues(Loop(start, count, targets, operands)):
            count += 1
        return Loop(start, count, targets, operands) if count >= shortest else None

    def _continues(self, loop: Loop) -> bool:
        """Whether the block after a loop belongs to it."""
        size = len(loop.targets)
        for offset, (target, operands) in enumerate(zip(loop.targets, loop.operands, strict=True)):
            each = self._statements[loop.end + offset]
            if target is not None and each.target != target.at(loop.count):
                return False
            for expected, operand in zip(operands, map(self._operand, each.operands), strict=True):
                if isinstance(expected, (Own, Carried)):
                    before = size if isinstance(expected, Carried) else 0
                    same = isinstance(operand, Value) and operand.statement == loop.end + expected.offset - before
                elif isinstance(expected, Entry):
                    same = operand == expected.at(loop.count)
                else:
                    same = operand == expected
                if not same:
                    return False
        return True

    def _write(self, loop: Loop) -> None:
        """Write a loop; what one pass hands to the next in a loop of its own, after that of all else."""
        self.has_loops = True
        number, size, carrying = len(self._moved) + len(self.written), len(loop.targets), loop.carrying
        parts = [[k for k in range(size) if (k in carrying) == each] for each in (False, True)]
        if "w" in loop.arrays:  # whose entries are read and written in the order of the statements
            parts = [list(range(size))]
        kept = {k: f"t{number}_{k}" for k in loop.read_by(parts[-1])} if len(parts) > 1 else {}
        lasts = dict[int, str]()
        for offset, target in enumerate(loop.targets):
            values = range(loop.start + offset, loop.end, size)
            read = [k for k, value in enumerate(values) if self._last.get(value, 0) >= loop.end]
            name = f"t{number}_{offset}"
            if target is None and read == [loop.count - 1] and offset not in kept:
                lasts[offset] = self._moved[values[-1]] = name
            elif target is None and read:
                kept[offset] = name
                self._moved |= {values[k]: Entry(name, k) for k in read}
        self.declared += [f"  casadi_real {name}[{loop.count}];" for name in kept.values()]
        self.kept += len(kept) * loop.count
        self.declared += [f"  casadi_real {name};" for name in lasts.values()]
        for part in parts:
            self.written += self._lines(loop, part, kept, lasts) if part else []

    def _lines(self, loop: Loop, part: Sequence[int], kept: Mapping[int, str], lasts: Mapping[int, str]) -> list[str]:
        """A loop with some of the statements.

        Args:
            loop: the loop.
            part: the statements.
            kept: the arrays in which those statements are kept that others read.
            lasts: the variables for the last values of statements.
        """
        carried = dict[Carried, str]()

        def name(operand: Operand | Own | Carried) -> object:
            if isinstance(operand, Carried):
                return carried.setdefault(operand, f"c{len(carried)}")
            outside = isinstance(operand, Own) and operand.offset not in part
            return Entry(kept[operand.offset], 0, 1) if outside else operand  # type: ignore[union-attr]

        inside = list[str]()
        for offset in part:
            target, operands = loop.targets[offset], [name(each) for each in loop.operands[offset]]
            text = self._statements[loop.start + offset].text(target or Own(offset), operands).strip()
            inside.append(text if target else f"const casadi_real {text}")
        inside += [f"{kept[offset]}[i] = b{offset};" for offset in part if offset in kept]
        inside += [f"{lasts[offset]} = b{offset};" for offset in part if offset in lasts]
        inside += [f"{own} = {name(Own(operand.offset))};" for operand, own in carried.items()]
        begin = [f"    casadi_real {own} = {operand.first};" for operand, own in carried.items()]
        kind = "JTIK_CARRIED" if carried else "" if "w" in loop.arrays else "JTIK_INDEPENDENT"
        lines = [f"    for (i=0; i<{loop.count}; ++i) {{", *(f"      {line}" for line in inside), "    }"]
        return ["  {", "    casadi_int i;", *begin, *([f"    {kind}"] if kind else []), *lines, "  }"]
