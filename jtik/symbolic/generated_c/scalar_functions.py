"""Functions of scalar operations in generated C, written so that compilers need less time and steps are faster.

CasADi tests at each entry of an input or output whether there is one; here each function does so once. Long functions
are divided: the time of a compiler grows faster than the length of the longest one. What is computed, and in which
order, stays the same, and so do all bits.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from jtik.symbolic.generated_c.branches import Statement, with_branches
from jtik.symbolic.generated_c.rolled_loops import rolled

LONGEST = 8000
"""A function with more statements is divided. A shorter one compiles in seconds and would lose a tenth of its speed."""

AS_LOOPS = 0.5
"""Share of `LONGEST` below which a function that would be divided is written with loops instead."""

PART = 1000
"""Number of statements of a part."""

_PARAMETERS = "const casadi_real** arg, casadi_real** res, casadi_int* iw, casadi_real* w, "
_HEAD = re.compile(rf"^(JTIK_SELDOM )?static int (casadi_f\d+)\({re.escape(_PARAMETERS)}int mem\) {{$")
_DECLARATION = re.compile(r"^  casadi_real a\d+(?:, a\d+)*;$")
_END = ("  return 0;", "}")
_INPUT = re.compile(r"arg\[(\d+)\]\? arg\[\1\]\[(\d+)\] : 0;")
_OUTPUT = re.compile(r"if \(res\[(\d+)\]!=0\) res\[\1\]\[(\d+)\]=")
_VARIABLE = re.compile(r"\b(a\d+)\b")
_GIVEN = r"(arg|res)\[\d+\](?:=w\+\d+;| = \1\[\d+\]\? \1\[\d+\] \+ \d+ : 0;)"
_CALL = re.compile(rf"^  (?:w\[\d+\] = |{_GIVEN}|if \(casadi_f\d+\(.*\)\) return 1;)$")


def with_scalar_functions_rewritten(source: str, longest: int = LONGEST, part: int = PART) -> str:
    """C as CasADi generates it, with its functions of scalar operations as described above; all others as they are.

    Args:
        source: the source, in which JTIK_PART is defined.
        longest: a function with at most so many statements stays whole.
        part: number of statements of a part.
    """
    lines, written, at = source.split("\n"), list[str](), 0
    while at < len(lines):
        head = _HEAD.match(lines[at])
        end = lines.index(_END[-1], at) + 1 if head else at + 1
        written += _rewritten(head, lines[at:end], longest, part) if head else lines[at:end]
        at = end
    return "\n".join(written)


def _rewritten(head: re.Match[str], lines: Sequence[str], longest: int, part: int) -> Sequence[str]:
    """The lines of a function and of its parts; those that are given where there are others than scalar operations."""
    first = 1
    while _DECLARATION.match(lines[first]):
        first += 1
    if first == 1 or tuple(lines[-2:]) != _END:
        return lines
    text, sizes = "\n".join(lines[first:-2]), dict[str, int]()
    for kind, pattern in (("x", _INPUT), ("y", _OUTPUT)):
        for index, entry in pattern.findall(text):
            sizes[kind + index] = max(sizes.get(kind + index, 1), int(entry) + 1)
    text = _OUTPUT.sub(r"y\1[\2]=", _INPUT.sub(r"x\1[\2];", text))
    statements = _Statements.of(text.split("\n"))
    if statements is None:
        return lines
    shorter = rolled(statements.text, longest if len(statements.text) <= longest else int(AS_LOOPS * longest))
    if shorter is not None:
        return [lines[0], *_inputs_and_outputs(sizes, shorter), shorter, *_END]
    if len(statements.text) <= longest:
        branches = with_branches(statements.alone)
        if branches:
            return [lines[0], *_inputs_and_outputs(sizes, branches), branches, *_END]
        return [*lines[:first], *_inputs_and_outputs(sizes, text), text, *_END]
    attribute, name, written, count = head[1] or "JTIK_PART ", head[2], list[str](), 0
    for count, (variables, body) in enumerate(statements.parts(part), start=1):
        written += [f"{attribute}static int {name}_{count}({_PARAMETERS}casadi_real* v) {{", variables]
        written += [*_inputs_and_outputs(sizes, body), body, *_END, ""]
    calls = [f"  if ({name}_{k}(arg, res, iw, w, v)) return 1;" for k in range(1, count + 1)]
    return [*written, lines[0], f"  casadi_real v[{max(statements.kept, 1)}];", *calls, *_END]


def _inputs_and_outputs(sizes: Mapping[str, int], text: str) -> list[str]:
    """Declarations of the inputs ``x`` and outputs ``y`` in a text: an input that is not given has zeros.

    Args:
        sizes: numbers of their entries, by name.
        text: the text.
    """
    declared = list[str]()
    for name, size in sizes.items():
        if f"{name}[" not in text:
            continue
        if name[0] == "x":
            declared.append(f"  static const casadi_real no_{name}[{size}] = {{0}};")
            declared.append(f"  const casadi_real* {name} = arg[{name[1:]}] ? arg[{name[1:]}] : no_{name};")
        else:
            declared.append(f"  casadi_real no_{name}[{size}];")
            declared.append(f"  casadi_real* {name} = res[{name[1:]}] ? res[{name[1:]}] : no_{name};")
    return declared


@dataclass
class _Statements:
    """Statements of scalar operations. A value has the number of the statement that assigns it to a variable.

    Attributes:
        text: each statement.
        assigned: the variable that each assigns; None for none.
        used: the variables that each needs, and their values.
        last: the last statement that needs each value.
        kept: number of values that have to be kept for later parts at the same time.
    """

    text: list[str]
    assigned: list[str | None] = field(default_factory=list)
    used: list[list[tuple[str, int]]] = field(default_factory=list)
    last: dict[int, int] = field(default_factory=dict)
    kept: int = 0

    @classmethod
    def of(cls, lines: list[str]) -> _Statements | None:
        """From the lines of a function; None where one of them is no statement that this class knows."""
        self, now = cls(lines), dict[str, int]()
        for at, line in enumerate(lines):
            pieces = _VARIABLE.split(line)  # text and variables in turn
            assigns = pieces[0] == "  " and len(pieces) > 1 and pieces[2].startswith(("=", " ="))
            known = assigns or pieces[0].startswith("  y") or _CALL.match(pieces[0])
            if not known or line.find(";") != len(line) - 1:
                return None
            used = [(each, now[each]) for each in pieces[3 if assigns else 1 :: 2]]
            for _, value in used:
                self.last[value] = at
            if assigns:
                now[pieces[1]] = at
            self.used.append(used)
            self.assigned.append(pieces[1] if assigns else None)
        return self

    @property
    def alone(self) -> list[Statement]:
        """Each statement with the values that it needs."""
        triples = zip(self.text, self.assigned, self.used, strict=True)
        return [Statement(text, assigned is not None, [value for _, value in used]) for text, assigned, used in triples]

    def parts(self, size: int) -> Iterator[tuple[str, str]]:
        """For functions of so many statements each, which together are the whole: their variables, and their bodies."""
        place, free = dict[int, int](), list[int]()
        for begin in range(0, len(self.text), size):
            end, body, read, variables = min(begin + size, len(self.text)), list[str](), set[int](), dict[str, None]()
            for at in range(begin, end):
                for variable, value in self.used[at]:
                    if value < begin and value not in read:
                        read.add(value)
                        variables[variable] = None
                        body.append(f"  {variable}=v[{place[value]}];")
                body.append(self.text[at])
                assigned = self.assigned[at]
                if assigned is None:
                    continue
                variables[assigned] = None
                if self.last.get(at, 0) >= end:
                    if not free:
                        free.append(self.kept)
                        self.kept += 1
                    place[at] = free.pop()
                    body.append(f"  v[{place[at]}]={assigned};")
            free += [place.pop(value) for value in sorted(read) if self.last[value] < end]
            yield f"  casadi_real {', '.join(variables)};" if variables else "", "\n".join(body)
