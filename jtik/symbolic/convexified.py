"""A symmetric matrix made positive definite by a modified L D L' factorisation (formulations/second_order.md)."""

from __future__ import annotations

import re
from functools import cache

from jtik.symbolic.operations import (
    MX,
    TINY,
    Expression,
    Function,
    diag,
    fabs,
    fmax,
    fmin,
    function,
    if_else,
    logic_and,
    norm_inf,
    tril,
    vec,
    vertcat,
)

FLAT = 1e-8
"""A pivot below this fraction of the largest entry counts as zero."""

RAISED = 1e-2
"""What such a pivot is raised to."""


def convexified(A: Expression) -> tuple[Expression, Expression, Expression]:
    """A symmetric matrix plus a diagonal that makes it positive definite.

    By the modified factorisation L D L' of Gill, Murray and Wright (1981): a pivot that is not above FLAT, or too small
    for the column it divides, is raised. The diagonal is exactly zero where A is positive definite.

    Args:
        A: symmetric matrix (n, n) with entries of order 1.

    Returns:
        The positive definite matrix (n, n), 1 where the diagonal is zero, and the smallest pivot or 0.
    """
    if isinstance(A, MX):
        definite_matrix, definite, lowest = _function(A.shape[0])(A)
        return definite_matrix, definite, lowest
    return _by_expressions(A)


def _by_expressions(A: Expression) -> tuple[Expression, Expression, Expression]:
    bound = fmax(2 * norm_inf(diag(A)), norm_inf(vec(tril(A)))) + TINY  # of any entry of L D^1/2, squared
    rest, added, definite, lowest = A, [], 1, 0  # only the lower triangle of what is left is used
    for _ in range(A.shape[0]):
        pivot, column = rest[0, 0], rest[1:, 0]
        smallest = norm_inf(vertcat(0, column)) ** 2 / bound
        good = logic_and(pivot > FLAT, pivot >= smallest)
        used = if_else(good, pivot, fmax(fmax(fabs(pivot), smallest), RAISED))
        added.append(used - pivot)
        definite = logic_and(definite, good)
        lowest = fmin(lowest, pivot)
        rest = rest[1:, 1:] - (column / used) @ column.T
    return A + diag(vertcat(*added)), definite, lowest


NAME = "jtik_convexified"
"""Name of the function, which generated C has in a form of its own: in CasADi's each pivot has a copy of the rest."""


@cache
def _function(n: int) -> Function:
    """The same for matrices of this size as a function."""
    A = MX.sym("A", n, n)
    return function(NAME, [A], _by_expressions(A), cse=False, inline=False)


_WRITTEN = re.compile(
    rf"^(/\* {NAME}:\(i0\[(?P<n>\d+)x\d+\]\)->\(o0\[\d+x\d+\],o1,o2\) \*/\n.*{{\n)(?:.*\n)*?}}\n", re.MULTILINE
)

_LEAST = 8
"""Fewest rows of a matrix that generated C has this form for."""

_LOOPS = """\
  /* "rest" has the columns of L under its diagonal, and above it, as rows, the same times their pivots. The last eight
   * sums of a column may overlap the diagonal; those are not read. */
  const casadi_real* A = arg[0];
  casadi_real *rest = w, *sums = w + {n} * {n}, bound = 0, lowest = 0;
  int i, j, k, definite = 1;
  for (j = 0; j < {n}; ++j) {{
    for (i = j; i < {n}; ++i) {{
      const casadi_real size = (i == j ? 2 : 1) * fabs(A[i + {n} * j]);
      if (size > bound) bound = size;
    }}
  }}
  bound += {tiny};
  for (i = 0; res[0] && i < {n} * {n}; ++i) res[0][i] = A[i];
  for (j = 0; j < {n}; ++j) {{
    const casadi_real* from = A + {n} * j;
    casadi_real *column = rest + {n} * j, largest = 0, pivot, smallest, used;
    int good;
    for (i = j; i < {n}; i += 8) {{
      k = i < {n} - 8 ? i : {n} - 8;
      JTIK_EIGHT(sums + k, from + k, column, 1, rest + k, {n}, j);
    }}
    for (i = j + 1; i < {n}; ++i) {{
      if (fabs(sums[i]) > largest) largest = fabs(sums[i]);
    }}
    pivot = sums[j], smallest = largest * largest / bound;
    good = pivot > {flat} && pivot >= smallest;
    used = good ? pivot : fmax(fmax(fabs(pivot), smallest), {raised});
    if (res[0]) res[0][({n} + 1) * j] += used - pivot;
    definite &= good;
    lowest = fmin(lowest, pivot);
    for (i = j + 1; i < {n}; ++i) {{
      rest[j + {n} * i] = sums[i];
      column[i] = sums[i] / used;
    }}
  }}
  if (res[1]) *res[1] = definite;
  if (res[2]) *res[2] = lowest;
  return 0;
}}
"""


def with_fast_factorisation(source: str) -> str:
    """Generated C in which this factorisation is by columns, in place.

    Args:
        source: the generated C.
    """

    def loops(match: re.Match[str]) -> str:
        if int(match["n"]) < _LEAST:
            return match[0]
        return match[1] + _LOOPS.format(n=match["n"], tiny=repr(TINY), flat=repr(FLAT), raised=repr(RAISED))

    return _WRITTEN.sub(loops, source)
