"""One expression graph as several functions in a row, each value computed once, as soon as it can be.

Between two functions of a step a solver answers. What the first has computed and the second needs again, such as a
factorisation, is handed on as numbers instead of being computed twice.
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

    Function k takes ``known[0]``, then for each earlier stage j what stage j handed on and ``known[j + 1]``; it
    returns ``wanted[k]`` and, all but the last, one column of what it hands on.

    Args:
        names: of the functions.
        known: symbols that come to be known before each stage.
        wanted: expressions of them that each stage has to give.
    """
    graph = _Graph.of(known, [[densify(each) for each in group] for group in wanted])
    handed: list[list[int]] = [[] for _ in names]
    for node in sorted(graph.used_later):
        handed[graph.stage[node]].append(node)
    columns = [symbol(f"handed{k}", len(nodes)) for k, nodes in enumerate(handed)]
    functions = []
    for k, name in enumerate(names):
        inputs = list(known[0])
        values: dict[int, Expression] = {}
        for j in range(k):
            inputs += [columns[j], *known[j + 1]]
            values |= {node: columns[j][i] for i, node in enumerate(handed[j])}
        graph.evaluate(k, values)
        outputs = [_filled(like, graph.results[k][i], values) for i, like in enumerate(wanted[k])]
        if k < len(names) - 1:
            outputs.append(vertcat(*[values[node] for node in handed[k]]) if handed[k] else zeros(0))
        functions.append(function(name, inputs, outputs))
    return functions


@dataclass
class _Graph:
    """The operations of all stages: each node an operation, its operands, and the stage from which it can be computed.

    Attributes: nodes, (operation, operands) in an order in which they can be computed; their values where they have
    one beforehand; stage, -1 of constants; used_later, nodes that a later stage needs; results, the nodes of each entry
    of each wanted expression.
    """

    nodes: list[tuple[int, tuple[int, ...]]]
    given: dict[int, Expression]
    stage: list[int]
    used_later: set[int]
    results: list[list[list[int]]]

    @classmethod
    def of(cls, known: Sequence[Sequence[Expression]], wanted: Sequence[Sequence[Expression]]) -> _Graph:
        """Read the instructions of one function of everything."""
        symbols = [(k, each) for k, group in enumerate(known) for each in group]
        outputs = [(k, i) for k, group in enumerate(wanted) for i in range(len(group))]
        whole = function("whole", [each for _, each in symbols], [wanted[k][i] for k, i in outputs])
        graph = cls([], {}, [], set(), [[[0] * each.numel() for each in group] for group in wanted])
        memory: dict[int, int] = {}
        for at in range(whole.n_instructions()):
            operation = whole.instruction_id(at)
            if operation == OP_OUTPUT:
                (k, i), entry = outputs[whole.instruction_output(at)[0]], whole.instruction_output(at)[1]
                node = memory[whole.instruction_input(at)[0]]
                graph.results[k][i][entry] = node
                graph._use(node, k)
                continue
            node = len(graph.nodes)
            operands: tuple[int, ...] = ()
            if operation == OP_INPUT:
                argument, entry = whole.instruction_input(at)
                stage, given = symbols[argument]
                graph.given[node] = given.nz[entry]
            elif operation == OP_CONST:
                stage = -1
                graph.given[node] = SX(whole.instruction_constant(at))
            else:
                operands = tuple(memory[place] for place in whole.instruction_input(at))
                stage = max(graph.stage[operand] for operand in operands)
            graph.nodes.append((operation, operands))
            graph.stage.append(stage)
            for operand in operands:
                graph._use(operand, stage)
            memory[whole.instruction_output(at)[0]] = node
        return graph

    def _use(self, node: int, stage: int) -> None:
        """Note that a stage needs a node; symbols and constants are there anyway."""
        if node not in self.given and self.stage[node] < stage:
            self.used_later.add(node)

    def evaluate(self, stage: int, values: dict[int, Expression]) -> None:
        """Add the values of all nodes of a stage to those that it is given."""
        values |= self.given
        for node, (operation, operands) in enumerate(self.nodes):
            if self.stage[node] != stage or node in values:
                continue
            if len(operands) == 1:
                values[node] = SX.unary(operation, values[operands[0]])
            else:
                values[node] = SX.binary(operation, values[operands[0]], values[operands[1]])


def _filled(like: Expression, nodes: Sequence[int], values: dict[int, Expression]) -> Expression:
    """A dense matrix of the shape of ``like``, columns first."""
    rows, columns = like.shape
    if not nodes:
        return SX.zeros(rows, columns)
    column = vertcat(*[values[node] for node in nodes])
    return column.reshape((rows, columns))
