"""Partition of an expression graph into consecutive functions (stages) that compute each value once.

Between two stages of a step a solver is called. Values that one stage computes and a later one needs, such as a
factorisation, are passed on as numbers instead of being computed twice.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from jtik.symbolic import (
    OP_CONST,
    OP_INPUT,
    OP_OUTPUT,
    SX,
    Expression,
    Function,
    densify,
    function,
    symbol,
    vertcat,
    zeros,
)


def partitioned(
    names: Sequence[str], known: Sequence[Sequence[Expression]], wanted: Sequence[Sequence[Expression]]
) -> list[Function]:
    """Functions that compute ``wanted[k]`` from the symbols ``known[0]`` to ``known[k]``.

    Args:
        names: names of the functions.
        known: symbols whose values become known before each stage.
        wanted: expressions that each stage returns.

    Returns:
        One function for each stage. Function k takes ``known[0]``, then for each earlier stage j the intermediate
        values of stage j and ``known[j + 1]``. It returns ``wanted[k]`` and, except for the last, one column of
        intermediate values.
    """
    graph = _Graph.of(known, [[densify(each) for each in group] for group in wanted])
    passed_on: list[list[int]] = [[] for _ in names]
    for node in sorted(graph.used_later):
        passed_on[graph.stage[node]].append(node)
    columns = [symbol(f"intermediate{k}", len(nodes)) for k, nodes in enumerate(passed_on)]
    functions = []
    for k, name in enumerate(names):
        inputs = list(known[0])
        values: dict[int, Expression] = {}
        for j in range(k):
            inputs += [columns[j], *known[j + 1]]
            values |= {node: columns[j][i] for i, node in enumerate(passed_on[j])}
        graph.evaluate(k, values)
        outputs = [_filled(like, graph.results[k][i], values) for i, like in enumerate(wanted[k])]
        if k < len(names) - 1:
            outputs.append(vertcat(*[values[node] for node in passed_on[k]]) if passed_on[k] else zeros(0))
        functions.append(function(name, inputs, outputs))
    return functions


@dataclass
class _Graph:
    """The operations of all stages as a graph.

    Attributes:
        nodes: (operation, operands) of each node, in an order in which they can be computed.
        given: values of the nodes that are symbols or constants.
        stage: first stage in which each node can be computed; -1 for constants.
        used_later: nodes that a later stage needs.
        results: nodes of each entry of each wanted expression of each stage.
    """

    nodes: list[tuple[int, tuple[int, ...]]]
    given: dict[int, Expression]
    stage: list[int]
    used_later: set[int]
    results: list[list[list[int]]]

    @classmethod
    def of(cls, known: Sequence[Sequence[Expression]], wanted: Sequence[Sequence[Expression]]) -> _Graph:
        """From the instructions of one function that computes all wanted expressions."""
        symbols = [(k, each) for k, group in enumerate(known) for each in group]
        outputs = [(k, i) for k, group in enumerate(wanted) for i in range(len(group))]
        joined = function("joined", [each for _, each in symbols], [wanted[k][i] for k, i in outputs])
        graph = cls([], {}, [], set(), [[[0] * each.numel() for each in group] for group in wanted])
        memory: dict[int, int] = {}
        for at in range(joined.n_instructions()):
            operation = joined.instruction_id(at)
            if operation == OP_OUTPUT:
                (k, i), entry = outputs[joined.instruction_output(at)[0]], joined.instruction_output(at)[1]
                node = memory[joined.instruction_input(at)[0]]
                graph.results[k][i][entry] = node
                graph._use(node, k)
                continue
            node = len(graph.nodes)
            operands: tuple[int, ...] = ()
            if operation == OP_INPUT:
                argument, entry = joined.instruction_input(at)
                stage, given = symbols[argument]
                graph.given[node] = given.nz[entry]
            elif operation == OP_CONST:
                stage = -1
                graph.given[node] = SX(joined.instruction_constant(at))
            else:
                operands = tuple(memory[place] for place in joined.instruction_input(at))
                stage = max(graph.stage[operand] for operand in operands)
            graph.nodes.append((operation, operands))
            graph.stage.append(stage)
            for operand in operands:
                graph._use(operand, stage)
            memory[joined.instruction_output(at)[0]] = node
        return graph

    def _use(self, node: int, stage: int) -> None:
        """Note that a stage needs a node; symbols and constants are available in every stage."""
        if node not in self.given and self.stage[node] < stage:
            self.used_later.add(node)

    def evaluate(self, stage: int, values: dict[int, Expression]) -> None:
        """Add the values of all nodes of a stage to the values that it is given."""
        values |= self.given
        for node, (operation, operands) in enumerate(self.nodes):
            if self.stage[node] != stage or node in values:
                continue
            if len(operands) == 1:
                values[node] = SX.unary(operation, values[operands[0]])
            else:
                values[node] = SX.binary(operation, values[operands[0]], values[operands[1]])


def _filled(like: Expression, nodes: Sequence[int], values: dict[int, Expression]) -> Expression:
    """The dense, column-major matrix of these nodes with the shape of ``like``."""
    rows, columns = like.shape
    if not nodes:
        return SX.zeros(rows, columns)
    column = vertcat(*[values[node] for node in nodes])
    return column.reshape((rows, columns))
