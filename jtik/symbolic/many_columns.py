"""A function of scalars for many columns of numbers at once: each of its operations is a loop over them."""

from __future__ import annotations

from collections.abc import Sequence

from jtik.symbolic.operations import MX, OP_CONST, OP_INPUT, OP_OUTPUT, Expression, Function


def of_many(function: Function, arguments: Sequence[Sequence[Expression]]) -> list[list[Expression]]:
    """The outputs of a function for many columns of each argument.

    Args:
        function: a function of scalar operations, without calls; its arguments and outputs are columns.
        arguments: the rows of each argument: expressions (1, k), or (1, 1) of what is the same in all columns.

    Returns:
        The rows of each output.
    """
    memory: dict[int, Expression] = {}
    outputs: list[list[Expression]] = [[None] * function.size1_out(i) for i in range(function.n_out())]
    for at in range(function.n_instructions()):
        operation, operands = function.instruction_id(at), function.instruction_input(at)
        if operation == OP_OUTPUT:
            output, entry = function.instruction_output(at)
            outputs[output][entry] = memory[operands[0]]
            continue
        if operation == OP_INPUT:
            result = arguments[operands[0]][operands[1]]
        elif operation == OP_CONST:
            result = MX(function.instruction_constant(at))
        elif len(operands) == 1:
            result = MX.unary(operation, memory[operands[0]])
        else:
            result = MX.binary(operation, *(memory[each] for each in operands))
        memory[function.instruction_output(at)[0]] = result
    return outputs
