"""Matrices one below the other, which generated C copies column by column: CasADi transposes each of them twice."""

from __future__ import annotations

import re

from jtik.symbolic.operations import MX, Expression, Function, function, vertcat

NAME = "jtik_stacked_rows"
"""Name of the function, which generated C has in a form of its own."""


def stacked(*matrices: Expression) -> Expression:
    """Matrices with the same number of columns, one below the other.

    Args:
        matrices: (k, n) each, dense expressions of matrices.
    """
    if len(matrices) == 1 or matrices[0].shape[1] == 1:
        return vertcat(*matrices)
    return _function(*(each.shape for each in matrices))(*matrices)


def _function(*shapes: tuple[int, int]) -> Function:
    symbols = [MX.sym(f"m{i}", *shape) for i, shape in enumerate(shapes)]
    return function(NAME, symbols, [vertcat(*symbols)], cse=False, inline=False)


_WRITTEN = re.compile(
    rf"^(/\* {NAME}:\((?P<given>[^)]*)\)->\(o0\[\d+x(?P<n>\d+)\]\) \*/\n.*{{\n)(?:.*\n)*?}}\n", re.MULTILINE
)


def with_stacked_rows(source: str) -> str:
    """Generated C in which these matrices are copied column by column.

    Args:
        source: the generated C.
    """

    def loops(match: re.Match[str]) -> str:
        n = int(match["n"])
        counts = [int(each) for each in re.findall(r"i\d+\[(\d+)", match["given"])]
        copies = "".join(
            f"    for (i=0; i<{count}; ++i) *to++ = arg[{k}] ? arg[{k}][{count}*j+i] : 0;\n"
            for k, count in enumerate(counts)
        )
        return (
            f"{match[1]}  casadi_real* to = res[0];\n  casadi_int i, j;\n  if (!to) return 0;\n"
            f"  for (j=0; j<{n}; ++j) {{\n{copies}  }}\n  return 0;\n}}\n"
        )

    return _WRITTEN.sub(loops, source)
