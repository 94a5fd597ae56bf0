"""Functions of scalar operations in generated C, written so that compilers need less time and steps are faster.

CasADi tests at each entry of an input or output whether there is one; here each function does so once. Each variable is
assigned once. Long functions are divided: the time of a compiler grows faster than the length of the longest one. What
is computed, and in which order, stays the same, and so do all bits.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

LONGEST = 3000
"""A function with more statements is divided; below, the time saved is not worth what a step loses by it."""

PART = 1000
"""Number of statements of a part."""

DEFINITIONS = """
#if defined(_MSC_VER)
#define JTIK_PART __declspec(noinline)
#else
#define JTIK_PART __attribute__((noinline))
#endif
"""
"""What C needs in which functions are divided."""

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
        source: the source, which begins with `DEFINITIONS`, or in which JTIK_PART is defined otherwise.
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
    attribute, name = head[1] or "JTIK_PART ", head[2]
    first = 1
    while _DECLARATION.match(lines[first]):
        first += 1
    if first == 1 or tuple(lines[-2:]) != _END:
        return lines
    function = _Function.of(lines[first:-2])
    if function is None:
        return lines
    if len(function.text) <= longest:
        return [lines[0], *next(function.parts(len(function.text))), *_END]
    written = list[str]()
    for body in function.parts(part):
        written += [f"{attribute}static int {name}_{function.count}({_PARAMETERS}casadi_real* v) {{", *body, *_END, ""]
    calls = [f"  if ({name}_{k}(arg, res, iw, w, v)) return 1;" for k in range(1, function.count + 1)]
    return [*written, lines[0], f"  casadi_real v[{max(function.kept, 1)}];", *calls, *_END]


@dataclass
class _Function:
    """Statements in which each variable is assigned once; the variable has the number of the statement.

    Attributes:
        text: each statement.
        used: the variables that each needs.
        assigns: whether each assigns one.
        last: the last statement that needs each variable.
        sizes: for each input ``x`` and output ``y`` a number of entries that is large enough.
        kept: number of variables that have to be kept for later parts at the same time.
        count: number of parts.
    """

    text: list[str] = field(default_factory=list)
    used: list[list[int]] = field(default_factory=list)
    assigns: list[bool] = field(default_factory=list)
    last: dict[int, int] = field(default_factory=dict)
    sizes: dict[str, int] = field(default_factory=dict)
    kept: int = 0
    count: int = 0

    @classmethod
    def of(cls, lines: Sequence[str]) -> _Function | None:
        """From the lines of a function; None where one of them is no statement that this class knows."""
        self, now = cls(), dict[str, int]()
        body = "\n".join(lines)
        for kind, pattern in (("x", _INPUT), ("y", _OUTPUT)):
            for index, entry in pattern.findall(body):
                self.sizes[kind + index] = max(self.sizes.get(kind + index, 1), int(entry) + 1)
        body = _OUTPUT.sub(r"y\1[\2]=", _INPUT.sub(r"x\1[\2];", body))
        for at, line in enumerate(body.split("\n")):
            pieces = _VARIABLE.split(line)  # text and variables in turn
            assigns = pieces[0] == "  " and len(pieces) > 1 and pieces[2].startswith(("=", " ="))
            known = assigns or pieces[0].startswith("  y") or _CALL.match(pieces[0])
            if not known or line.find(";") != len(line) - 1:
                return None
            begin = 3 if assigns else 1
            used = [now[each] for each in pieces[begin::2]]
            pieces[begin::2] = [f"a{each}" for each in used]
            if assigns:
                now[pieces[1]] = at
                pieces[:2] = ["  const casadi_real ", f"a{at}"]
            for each in used:
                self.last[each] = at
            self.used.append(used)
            self.assigns.append(assigns)
            self.text.append("".join(pieces))
        return self

    def parts(self, size: int) -> Iterator[list[str]]:
        """The bodies of functions of so many statements each; together they are the function."""
        place, free = dict[int, int](), list[int]()
        for begin in range(0, len(self.text), size):
            end, body, known = min(begin + size, len(self.text)), list[str](), set[int]()
            for at in range(begin, end):
                for each in self.used[at]:
                    if each < begin and each not in known:
                        known.add(each)
                        body.append(f"  const casadi_real a{each} = v[{place[each]}];")
                body.append(self.text[at])
                if self.assigns[at] and self.last.get(at, 0) >= end:
                    if not free:
                        free.append(self.kept)
                        self.kept += 1
                    place[at] = free.pop()
                    body.append(f"  v[{place[at]}] = a{at};")
            free += [place.pop(each) for each in sorted(known) if self.last[each] < end]
            self.count += 1
            yield [*self._inputs_and_outputs(body), *body]

    def _inputs_and_outputs(self, body: Sequence[str]) -> list[str]:
        """Declarations of the inputs and outputs that these statements use: zeros for an input that is not given."""
        text, declared = "\n".join(body), list[str]()
        for name, size in self.sizes.items():
            if f"{name}[" not in text:
                continue
            if name[0] == "x":
                declared.append(f"  static const casadi_real no_{name}[{size}] = {{0}};")
                declared.append(f"  const casadi_real* {name} = arg[{name[1:]}] ? arg[{name[1:]}] : no_{name};")
            else:
                declared.append(f"  casadi_real no_{name}[{size}];")
                declared.append(f"  casadi_real* {name} = res[{name[1:]}] ? res[{name[1:]}] : no_{name};")
        return declared
