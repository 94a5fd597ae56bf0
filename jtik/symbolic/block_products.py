"""Products of blocks of rows with a matrix each, which in generated C are loops over the rows."""

from __future__ import annotations

import re

from jtik.symbolic.operations import MX, Expression, Function, function, vertcat

NAME = "jtik_block_products"
"""Name of the function, which generated C has in a form of its own."""


def block_products(rows: Expression, matrices: Expression, blocks: int) -> Expression:
    """The products of each block of rows (k, e) with its matrix, one below the other (k, n).

    Args:
        rows: (blocks k, more + e), of which the last columns are multiplied.
        matrices: one beside the other (e, blocks n).
        blocks: number of blocks.
    """
    return _function(rows.shape, matrices.shape, blocks)(rows, matrices)


def _function(rows: tuple[int, int], matrices: tuple[int, int], blocks: int) -> Function:
    left, right = MX.sym("rows", *rows), MX.sym("matrices", *matrices)
    k, n, first = rows[0] // blocks, matrices[1] // blocks, rows[1] - matrices[0]
    products = [left[b * k : (b + 1) * k, first:] @ right[:, b * n : (b + 1) * n] for b in range(blocks)]
    return function(NAME, [left, right], [vertcat(*products)], cse=False, inline=False)


_WRITTEN = re.compile(
    rf"^(/\* {NAME}:\(i0\[(?P<rows>\d+)x(?P<all>\d+)\],i1\[(?P<e>\d+)x(?P<columns>\d+)\]\)"
    r"->\(o0\[\d+x(?P<n>\d+)\]\) \*/\n.*{\n)"
    r"(?:.*\n)*?}\n",
    re.MULTILINE,
)

_LOOPS = """\
  const casadi_real *x = arg[0], *y = arg[1];
  casadi_real *z = res[0];
  casadi_int b, c, i;
  if (z==0) return 0;
  for (b=0; b<{blocks}; ++b, x+={k}, z+={k}) {{
    for (c=0; c<{n}; ++c, y+={e}) {{
      casadi_real* JTIK_RESTRICT to = z + {rows}*c;
      for (i=0; i<{k}; ++i) to[i] = {product};
    }}
  }}
  return 0;
}}
"""


def with_block_loops(source: str) -> str:
    """Generated C in which these products are loops.

    Args:
        source: the generated C.
    """

    def loops(match: re.Match[str]) -> str:
        rows, every, e, columns, n = (int(match[name]) for name in ("rows", "all", "e", "columns", "n"))
        blocks, first = columns // n, every - e
        product = " + ".join(f"x[i + {rows * (first + j)}] * y[{j}]" for j in range(e))
        return match[1] + _LOOPS.format(blocks=blocks, k=rows // blocks, n=n, e=e, rows=rows, product=product)

    return _WRITTEN.sub(loops, source)
