"""Matrix operations in generated C as few loops: what is computed entry by entry stays in registers.

CasADi writes a loop for each operation on a matrix, which reads its operands from memory and writes its result there,
and copies what is an output at the end. Here loops that follow one another over entries of the same number are one, a
result that nothing reads afterwards is not written, and a large output is computed where it belongs. What is computed
for each entry, and in which order, stays the same, and so do all bits.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

SHORT = 32
"""Loops over fewer entries stay as they are."""

SEVERAL = 2
"""Operations from which on they are fused."""

LARGE = 64
"""Entries of an output from which on it is computed where it belongs."""

_BEGIN = re.compile(r"^(?:\w+ )?static int casadi_f\d+\(const casadi_real\*\* arg, .*\) \{$", re.MULTILINE)
_END = "\n}\n"
_POINTER = re.compile(r"\*(w\d+)=w\+(\d+)")
_COMMENT = re.compile(r"^  /\* #\d+: .* \*/$")

_LOOP = re.compile(
    r"^  for \(i=0, rr=(?P<rr>w\d+)(?:, cr=(?P<cr>wr?\d+))?(?:, cs=(?P<cs>wr?\d+))?; i<(?P<n>\d+); \+\+i\) "
    r"(?:\(\*rr\+\+\)|\*rr\+\+) +(?P<before>[-+*/]?)= ?(?P<value>[^;\n]*);$"
)
_PART = re.compile(
    r"^  for \(rr=(?P<rr>w\d+), cs=(?P<cs>wr?\d+)\+(?P<begin>\d+); cs!=(?P=cs)\+(?P<end>\d+); cs\+=1\) "
    r"\*rr\+\+ = \*cs;$"
)
_COPY = re.compile(r"^  casadi_copy\((?P<from>w\d+), (?P<n>\d+), (?P<to>w\d+|res\[\d+\])\);$")
_FILL = re.compile(
    r"^  casadi_(?:fill\((?P<rr>w\d+), (?P<n>\d+), (?P<value>[^\n]*)\)|clear\((?P<zeros>w\d+), (?P<cleared>\d+)\));$"
)
_NUMBER = re.compile(r"^  (?P<to>w\d+) +(?P<before>[-+*/]?)= (?P<value>[^;\n]*);$")
_NAME = re.compile(r"\bwr?\d+\b")
_ENTRY = re.compile(r"\(\*(cr|cs)\+\+\)|\*(cs)\+\+|\b(cr|cs)\[i\]")
_POSITION = re.compile(r"\b(?:rr|cr|cs)\b")


def with_fused_loops(source: str) -> str:
    """C as CasADi generates it, with its functions of matrix operations as described above; all others as they are.

    Args:
        source: the source, in which JTIK_INDEPENDENT is defined.
    """
    written, at = list[str](), 0
    for begin in _BEGIN.finditer(source):
        end = source.index(_END, begin.end()) + 1
        body = source[begin.end() + 1 : end]
        if "rr=" in body or "casadi_copy(w" in body:
            written += [source[at : begin.end() + 1], _rewritten(body)]
            at = end
    return "".join([*written, source[at:]])


def _rewritten(body: str) -> str:
    lines = body.split("\n")
    first = next((i for i, line in enumerate(lines) if _COMMENT.match(line)), len(lines))
    declared, lines = lines[:first], lines[first:]
    places = {name: int(place) for name, place in _POINTER.findall("\n".join(declared))}
    moved, lines = _in_place(lines, places)
    known = [f"  if ({to}) {name} = {to};" for name, to in moved.items()]
    return "\n".join([*declared, *known, *_fused(lines, set(places), set(moved))])


def _in_place(lines: Sequence[str], places: Mapping[str, int]) -> tuple[dict[str, str], list[str]]:
    """The vectors that move to the memory of the outputs that they are in the end, and the lines without these copies.

    A vector moves that nothing writes after it is copied to its output.

    Args:
        lines: the statements.
        places: of each vector where it begins.
    """
    ends = dict(pairwise(sorted(places.values())))
    moved, left = dict[str, str](), list[str]()
    for at, line in enumerate(lines):
        copy = _COPY.match(line)
        name, to = (copy["from"], copy["to"]) if copy else ("", "")
        large = copy is not None and to.startswith("res") and int(copy["n"]) >= LARGE
        if large and name in places and name not in moved and copy is not None:
            whole = ends.get(places[name], 0) - places[name] == int(copy["n"])
            if whole and not any(name in other and _writes(other, name) for other in lines[at + 1 :]):
                moved[name] = to
                continue
        left.append(line)
    return moved, left


def _writes(line: str, name: str) -> bool:
    """Whether a line may write a vector."""
    if _COMMENT.match(line) or name not in _NAME.findall(line):
        return False
    loop, copy = _LOOP.match(line) or _PART.match(line), _COPY.match(line)
    if loop:
        return loop["rr"] == name
    return copy["to"] == name if copy else not line.startswith("  arg1[")


def _reads(line: str, name: str) -> bool:
    """Whether a line may read a vector; one that does not, and names it, writes all of it."""
    loop, part, copy = _LOOP.match(line), _PART.match(line), _COPY.match(line)
    if loop:
        return bool(loop["before"]) or name in (loop["cr"], loop["cs"])
    if part:
        return bool(part["cs"] == name)
    if copy:
        return bool(copy["from"] == name)
    return not (_FILL.match(line) or line.startswith("  res1[") or line.startswith("  casadi_copy(arg["))


@dataclass
class _Fused:
    """Loops that become one.

    Attributes:
        vectors: all vectors of the function.
        count: number of entries.
        given: the lines that it replaces.
        begin: statements before the loop.
        entry: statements for an entry.
        values: the variable of an entry of each vector that has been read or written, and of each number.
        written: the vectors that have been written.
        outputs: the outputs, the vector and the variable of an entry of each.
    """

    vectors: set[str]
    count: int
    given: list[str] = field(default_factory=list)
    begin: list[str] = field(default_factory=list)
    entry: list[str] = field(default_factory=list)
    values: dict[str, str] = field(default_factory=dict)
    written: dict[str, None] = field(default_factory=dict)
    outputs: list[tuple[str, str, str]] = field(default_factory=list)

    def takes(self, line: str) -> bool:
        """Add what a line does; False, and nothing is added, where it does not belong to this loop."""
        if _count(line) != self.count:
            return self._takes_number(line)
        loop, part, copy, fill = _LOOP.match(line), _PART.match(line), _COPY.match(line), _FILL.match(line)
        if loop:
            value = _ENTRY.sub(lambda entry: self.value(loop[entry[1] or entry[2] or entry[3]]), loop["value"])
            value = _NAME.sub(lambda name: self.value(name[0]), value)
            self.write(loop["rr"], f"{self.value(loop['rr'])} {loop['before']} {value}" if loop["before"] else value)
        elif part:  # of a vector with more entries, which this loop does not write
            self.write(part["rr"], f"{part['cs']}[i+{part['begin']}]")
        elif copy and copy["to"].startswith("res"):
            self.outputs.append((copy["to"], copy["from"], self.value(copy["from"])))
        elif copy:
            self.write(copy["to"], self.value(copy["from"]))
        elif fill:
            self.write(fill["rr"] or fill["zeros"], _NAME.sub(lambda name: self.value(name[0]), fill["value"] or "0."))
        self.given.append(line)
        return True

    def _takes_number(self, line: str) -> bool:
        """The same for a statement of numbers alone."""
        number = _NUMBER.match(line)
        if number is None or any(name in self.vectors or name.startswith("wr") for name in _NAME.findall(line)):
            return False
        self.begin.append(line.strip())
        self.values.pop(number["to"], None)
        self.given.append(line)
        return True

    def value(self, name: str) -> str:
        """The variable of an entry of a vector, or of a number."""
        if name not in self.values:
            if name in self.vectors or name.startswith("wr"):
                self.values[name] = self._entry(f"{name}[i]")
            else:
                self.values[name] = f"n{len(self.begin)}"
                self.begin.append(f"const casadi_real n{len(self.begin)} = {name};")
        return self.values[name]

    def write(self, vector: str, value: str) -> None:
        """Set a vector."""
        self.values[vector] = self._entry(value)
        self.written[vector] = None

    def _entry(self, value: str) -> str:
        name = f"e{len(self.entry)}"
        self.entry.append(f"const casadi_real {name} = {value};")
        return name

    def lines(self, following: Sequence[str], kept: set[str]) -> list[str]:
        """The loop; the lines that it replaces where they are one operation.

        Args:
            following: the lines after it.
            kept: the vectors that are read after the last line.
        """
        if len(self.written) + len(self.outputs) < SEVERAL and len(self.entry) < SEVERAL:
            return self.given
        outputs = [f"casadi_real* o{k} = {to} ? {to} : {vector};" for k, (to, vector, _) in enumerate(self.outputs)]
        stored = [f"o{k}[i] = {value};" for k, (*_, value) in enumerate(self.outputs)]
        stored += [
            f"{each}[i] = {self.values[each]};" for each in self.written if each in kept or _is_read(following, each)
        ]
        return [
            "  {",
            *(f"    {line}" for line in ["casadi_int i;", *self.begin, *outputs]),
            "    JTIK_INDEPENDENT",
            f"    for (i=0; i<{self.count}; ++i) {{",
            *(f"      {line}" for line in [*self.entry, *stored]),
            "    }",
            "  }",
        ]


def _is_read(lines: Sequence[str], vector: str) -> bool:
    """Whether lines read a vector before they write all of it."""
    for line in lines:
        if vector in line and not _COMMENT.match(line) and vector in _NAME.findall(line):
            return _reads(line, vector)
    return False


def _fused(lines: Sequence[str], vectors: set[str], kept: set[str]) -> list[str]:
    """The lines with loops that follow one another as one.

    Args:
        lines: the statements.
        vectors: all vectors of the function.
        kept: those that are read after the last line.
    """
    written, comments, current = list[str](), list[str](), None
    for at, line in enumerate(lines):
        if _COMMENT.match(line):
            comments.append(line)
            continue
        if current is not None and not current.takes(line):
            written += current.lines(lines[at:], kept)
            current = None
        elif current is not None:
            comments.clear()
            continue
        count = _count(line)
        if count >= SHORT:
            current = _Fused(vectors, count)
            if not current.takes(line):
                current = None
        written += comments
        comments.clear()
        if current is None:
            written.append(line)
    return [*written, *comments]


def _count(line: str) -> int:
    """Number of entries of a loop; 0 for other lines."""
    loop, part, copy, fill = _LOOP.match(line), _PART.match(line), _COPY.match(line), _FILL.match(line)
    if part:
        return int(part["end"]) - int(part["begin"])
    if fill:
        return int(fill["n"] or fill["cleared"])
    if loop and _POSITION.search(_ENTRY.sub("", loop["value"])):  # another form than those that are known
        return 0
    found = loop or copy
    return int(found["n"]) if found else 0
