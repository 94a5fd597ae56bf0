"""Entries of a vector that are picked by number: generated C picks runs of them in a loop.

CasADi's C has a number for each entry that it picks. Where many are runs, such as the figures of one obstacle after
another, or one number for all of them, it is a table of runs here, and each is a loop that compilers make vectors of.
"""

from __future__ import annotations

import re

_PICKED = re.compile(
    r"^  for \(cii=(?P<table>casadi_s\d+), rr=(?P<to>[^,]+), cs=(?P<of>[^;]+); "
    r"cii!=(?P=table)\+(?P<count>\d+); \+\+cii\) \*rr\+\+ = cs\[\*cii\];$"
    r"(?P<copied>\n  /\*.*\n  casadi_copy\((?P=to), (?P=count), (?P<output>res\[\d+\])\);(?=\n  return 0;))?",
    re.MULTILINE,
)
_TABLE = r"^static const casadi_int {table}\[\d+\] =\s*{{(?P<numbers>[^}}]*)}};"

_FEWEST = 8
"""Mean length of the runs from which on they are loops."""

_RUNS = r"""
/* Runs of numbers of a vector, one after the other: each of (first, step, length). */
static void JTIK_RUNS(casadi_real* to, const casadi_real* from, const casadi_int* runs, casadi_int count) {
  for (; count > 0; --count, to += runs[2], runs += 3) {
    const casadi_real* first = from + runs[0];
    const casadi_int step = runs[1], length = runs[2];
    casadi_int i;
    if (step == 0) {
      const casadi_real value = *first;
      for (i = 0; i < length; ++i) to[i] = value;
    } else if (step == 1) {
      JTIK_INDEPENDENT
      for (i = 0; i < length; ++i) to[i] = first[i];
    } else {
      for (i = 0; i < length; ++i) to[i] = first[step * i];
    }
  }
}
"""


def with_runs(source: str) -> str:
    """Generated C with these loops.

    Args:
        source: the generated C, in which JTIK_INDEPENDENT is defined.
    """
    replaced = dict[str, int]()

    def loop(match: re.Match[str]) -> str:
        table, count = match["table"], int(match["count"])
        found = re.search(_TABLE.format(table=table), source, re.MULTILINE)
        if found is None:
            return match[0]
        numbers = [int(each) for each in found["numbers"].split(",")]
        runs = _runs(numbers)
        if len(numbers) != count or count < _FEWEST * len(runs):
            return match[0]
        replaced[table] = len(runs)
        to = match["output"] or match["to"]
        picked = f"JTIK_RUNS({to}, {match['of']}, {table}, {len(runs)});"
        return f"  if ({to}) {picked}" if match["output"] else f"  {picked}"

    written = _PICKED.sub(loop, source)
    for table in replaced:
        if written.count(f"{table}+") or len(re.findall(rf"\b{table}\b", written)) < 2:
            return source
        found = re.search(_TABLE.format(table=table), source, re.MULTILINE)
        assert found is not None
        runs = _runs([int(each) for each in found["numbers"].split(",")])
        numbers = ", ".join(str(number) for run in runs for number in run)
        written = written.replace(found[0], f"static const casadi_int {table}[{3 * len(runs)}] = {{{numbers}}};")
    first = re.search(r"^static const casadi_int casadi_s\d+\[", written, re.MULTILINE)
    if not replaced or first is None:
        return source
    return written[: first.start()] + _RUNS + "\n" + written[first.start() :]


def _runs(numbers: list[int]) -> list[tuple[int, int, int]]:
    """The numbers as runs: first, step, length."""
    runs, at = list[tuple[int, int, int]](), 0
    while at < len(numbers):
        end, step = at + 1, numbers[at + 1] - numbers[at] if at + 1 < len(numbers) else 1
        while end < len(numbers) and numbers[end] - numbers[end - 1] == step:
            end += 1
        runs.append((numbers[at], step, end - at))
        at = end
    return runs
