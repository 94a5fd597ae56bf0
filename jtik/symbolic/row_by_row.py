"""A function of one column of numbers for many of them, the rows of a matrix.

On the virtual machine each of its operations is a loop over the rows. In generated C there is one loop over the rows
with the function in it, several rows side by side where the compiler has vector instructions. The bits are the same.
"""

from __future__ import annotations

import re

from jtik.symbolic.operations import MX, OP_CONST, OP_INPUT, OP_OUTPUT, Expression, Function, function, horzcat, repmat

NAME = "jtik_row_by_row"
"""Name of the function, which generated C has in a form of its own."""


def row_by_row(one: Function, rows: Expression) -> Expression:
    """The outputs of a function for the rows of a matrix, one below the other (k, s).

    Args:
        one: (r, 1) -> (s, 1), a function of scalar operations, without calls.
        rows: (k, r).
    """
    key = hash(one), rows.shape[0]
    if key not in _built:
        _built[key] = _function(one, rows.shape[0])
    result: Expression = _built[key](rows)[0]
    return result


_built: dict[tuple[int, int], Function] = {}


def _function(one: Function, count: int) -> Function:
    rows = MX.sym("rows", count, one.size1_in(0))
    memory: dict[int, Expression] = {}
    columns: list[Expression] = [MX(0)] * one.size1_out(0)
    for at in range(one.n_instructions()):
        operation, operands = one.instruction_id(at), one.instruction_input(at)
        if operation == OP_OUTPUT:
            columns[one.instruction_output(at)[1]] = memory[operands[0]]
            continue
        if operation == OP_INPUT:
            result = rows[:, operands[1]]
        elif operation == OP_CONST:
            result = MX(one.instruction_constant(at))
        elif len(operands) == 1:
            result = MX.unary(operation, memory[operands[0]])
        else:
            result = MX.binary(operation, *(memory[each] for each in operands))
        memory[one.instruction_output(at)[0]] = result
    long = [repmat(column, count // column.shape[0], 1) for column in columns]  # what all rows share is a number
    # the second output is there for generated C, which then has the function
    return function(NAME, [rows], [horzcat(*long), one(rows[0, :].T)], cse=False, inline=False)


_WRITTEN = re.compile(
    rf"^(/\* {NAME}:\(i0\[(?P<k>\d+)(?:x(?P<r>\d+))?\]\)->\(o0\[\d+(?:x(?P<s>\d+))?\],o1\S*\) \*/\n.*{{\n)"
    r"(?P<body>(?:(?!}).*\n)*)}\n",
    re.MULTILINE,
)

_CALL = re.compile(r"(casadi_f\d+)\(arg1, res1, iw, w, 0\)")

_LOOP = """\
  const casadi_real* given = arg[0];
  casadi_real* JTIK_RESTRICT found = res[0];
  casadi_int i;
  for (i=0; i<{k}; ++i) {{
    const casadi_real row[{r}] = {{{read}}}, *arg1[1] = {{row}};
    casadi_real result[{s}], *res1[1] = {{result}};
    {one}(arg1, res1, 0, 0, 0);
    {written}
  }}
  return 0;
}}
"""


def with_row_loops(source: str) -> str:
    """Generated C in which these functions are loops.

    Args:
        source: the generated C.
    """

    called = set[str]()

    def loop(match: re.Match[str]) -> str:
        call, s, r, k = _CALL.search(match["body"]), int(match["s"] or 1), int(match["r"] or 1), int(match["k"])
        if call is None:
            return match[0]
        called.add(call[1])
        read = ", ".join(f"given[i + {k * j}]" for j in range(r))
        written = " ".join(f"found[i + {k * j}] = result[{j}];" for j in range(s))
        return match[1] + _LOOP.format(r=r, k=k, s=s, one=call[1], read=read, written=written)

    source = _WRITTEN.sub(loop, source)
    for name in called:
        source = source.replace(f"\nstatic int {name}(", f"\nJTIK_INLINED static int {name}(")
    return source
