"""Groups of expressions as functions of their own: what several groups need is computed once, before them."""

from __future__ import annotations

from collections.abc import Sequence

from jtik.qp.partition import Call, Graph, filled
from jtik.symbolic import Expression, Function, densify, function, symbol, vertcat, zeros

SEVERAL = -1
"""What a node belongs to that several groups need."""


def divided(name: str, inputs: Sequence[Expression], groups: Sequence[Expression]) -> tuple[Function, list[Function]]:
    """A function for what several groups need, and one for each group.

    Args:
        name: the first part of the names of the functions.
        inputs: symbols.
        groups: an expression of them for each group.

    Returns:
        (inputs) -> the shared values, a column; and for each group (inputs, shared values) -> its expression.
    """
    dense = [densify(each) for each in groups]
    graph = Graph.of([inputs], [dense], [])
    owner = _owners(graph)
    parts = {g: [node for node in sorted(owner) if owner[node] == g] for g in range(SEVERAL, len(groups))}
    needed = {operand for node, g in owner.items() if g != SEVERAL for operand in graph.nodes[node][1]}
    needed.update(node for group in graph.results[0] for node in group)
    passed = [node for node in parts[SEVERAL] if node in needed]
    values: dict[int, Expression] = {}
    graph.evaluate(parts[SEVERAL], values)
    column = vertcat(*[values[node] for node in passed]) if passed else zeros(0)
    shared = function(f"{name}_shared", inputs, [column], cse=False)
    known, own = symbol("shared", len(passed)), list[Function]()
    for g, like in enumerate(dense):
        values = {node: known[i] for i, node in enumerate(passed)}
        graph.evaluate(parts[g], values)
        expression = filled(like, graph.results[0][g], values)
        own.append(function(f"{name}_{g}", [*inputs, known], [expression], cse=False))
    return shared, own


def _owners(graph: Graph) -> dict[int, int]:
    """The group that each node belongs to, or `SEVERAL`, of all nodes that are neither inputs nor constants."""
    owner: dict[int, int] = {}
    by_call: dict[Call, list[int]] = {}
    for node, (call, _) in graph.calls.items():
        by_call.setdefault(call, []).append(node)

    def claim(node: int, by: int) -> None:
        if node not in graph.given:
            owner[node] = by if owner.get(node, by) == by else SEVERAL

    for g, nodes in enumerate(graph.results[0]):
        for node in nodes:
            claim(node, g)
    for node in reversed(range(len(graph.nodes))):
        if node in graph.calls:  # a call belongs to one group with all its results
            together = [each for each in by_call[graph.calls[node][0]] if each in owner]
            found = {owner[each] for each in together}
            for each in together:
                owner[each] = found.pop() if len(found) == 1 else SEVERAL
                found = {owner[each]}
        if node in owner:
            for operand in graph.nodes[node][1]:
                claim(operand, owner[node])
    return owner
