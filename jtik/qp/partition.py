"""Partition of an expression graph into consecutive functions (stages) that compute each value once.

Between two stages of a step a solver is called. Values that one stage computes and a later one needs, such as a
factorisation, are passed on as numbers instead of being computed twice.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence, Set
from dataclasses import dataclass

from jtik.symbolic import (
    OP_CALL,
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
    names: Sequence[str],
    known: Sequence[Sequence[Expression]],
    wanted: Sequence[Sequence[Expression]],
    deferred: Sequence[Sequence[Expression]] = (),
) -> tuple[list[Function], list[Function]]:
    """Functions that compute ``wanted[k]`` from the symbols ``known[0]`` to ``known[k]``.

    Args:
        names: names of the functions.
        known: symbols whose values become known before each stage.
        wanted: expressions that each stage returns.
        deferred: expressions that are computed after a stage, where they are needed; for the first stages, or for all
            but the last.

    Returns:
        One function for each stage. Function k takes ``known[0]``, then for each earlier stage j the intermediate
        values of stage j and ``known[j + 1]``. It returns ``wanted[k]`` and, except for the last, one column of
        intermediate values. Then one function for each of ``deferred``, which takes what that stage takes and its
        intermediate values. What only such functions need is computed in them.
    """
    dense, later = ([[densify(each) for each in group] for group in groups] for groups in (wanted, deferred))
    graph = Graph.of(known, dense, later)  # which has each value once
    passed_on: list[list[int]] = [[] for _ in names]
    for node in sorted(graph.used_later):
        passed_on[graph.stage[node]].append(node)
    columns = [symbol(f"intermediate{k}", len(nodes)) for k, nodes in enumerate(passed_on)]
    stages, after = list[Function](), list[Function]()
    inputs, passed = list(known[0]), dict[int, Expression]()
    for k, name in enumerate(names):
        values = dict(passed)
        graph.evaluate([node for node in graph.computed if graph.stage[node] == k], values)
        outputs = [filled(like, graph.results[k][i], values) for i, like in enumerate(wanted[k])]
        if k == len(names) - 1:
            stages.append(function(name, inputs, outputs, cse=False))
            break
        outputs.append(vertcat(*[values[node] for node in passed_on[k]]) if passed_on[k] else zeros(0))
        stages.append(function(name, inputs, outputs, cse=False))
        passed |= {node: columns[k][i] for i, node in enumerate(passed_on[k])}
        if k < len(deferred):
            values = dict(passed)
            graph.evaluate(graph.only_deferred[k], values)
            outputs = [filled(like, graph.deferred[k][i], values) for i, like in enumerate(deferred[k])]
            after.append(function(f"{name}_data", [*inputs, columns[k]], outputs, cse=False))
        inputs = [*inputs, columns[k], *known[k + 1]]
    return stages, after


@dataclass(frozen=True, eq=False)
class Call:
    """A call of a function that cannot be written out as operations, such as a numeric criterion or an interpolant.

    Attributes:
        function: the function.
        operands: nodes of the nonzero entries of its arguments, one argument after the other.
    """

    function: Function
    operands: tuple[int, ...]

    def results(self, values: dict[int, Expression]) -> list[Expression]:
        """The nonzero entries of its results, one result after the other."""
        arguments, start = [], 0
        for i in range(self.function.n_in()):
            end = start + self.function.nnz_in(i)
            entries = [values[node] for node in self.operands[start:end]]
            arguments.append(SX(self.function.sparsity_in(i), vertcat(*entries)))
            start = end
        results = self.function.call(arguments, False, True)  # as a call, not written out
        return [result.nz[i] for result in results for i in range(result.nnz())]


@dataclass
class Graph:
    """The operations of all stages as a graph.

    Attributes:
        nodes: (operation, operands) of each node, in an order in which they can be computed.
        given: values of the nodes that are symbols or constants.
        stage: first stage in which each node can be computed; -1 for constants.
        results: nodes of each entry of each wanted expression of each stage.
        deferred: the same of the deferred expressions.
        computed: nodes that a stage computes, in order.
        used_later: nodes that another function than that of their stage needs.
        only_deferred: for each stage the nodes that its deferred expressions need and no stage computes, in order.
        calls: the call that computes a node, and which of the entries of its results the node is.
    """

    nodes: list[tuple[int, tuple[int, ...]]]
    given: dict[int, Expression]
    stage: list[int]
    results: list[list[list[int]]]
    deferred: list[list[list[int]]]
    computed: list[int]
    used_later: set[int]
    only_deferred: list[list[int]]
    calls: dict[int, tuple[Call, int]]

    @classmethod
    def of(
        cls,
        known: Sequence[Sequence[Expression]],
        wanted: Sequence[Sequence[Expression]],
        deferred: Sequence[Sequence[Expression]],
    ) -> Graph:
        """From the instructions of one function that computes all expressions."""
        symbols = [(k, each) for k, group in enumerate(known) for each in group]
        results, later = ([[[0] * each.numel() for each in group] for group in groups] for groups in (wanted, deferred))
        outputs = [
            (nodes, each) for at, of in ((results, wanted), (later, deferred)) for nodes, each in _paired(at, of)
        ]
        # common expressions are found below: that takes less time than CasADi needs for it
        joined = function("joined", [each for _, each in symbols], [each for _, each in outputs], cse=False)
        graph = cls([], {}, [], results, later, [], set(), [], {})
        memory: dict[int, int] = {}
        known_nodes: dict[tuple[int, tuple[int, ...]], int] = {}
        known_calls: dict[tuple[int, tuple[int, ...]], tuple[Call, dict[int, int]]] = {}
        written = joined.instructions_sx()
        for at in range(joined.n_instructions()):
            operation = joined.instruction_id(at)
            if operation == OP_OUTPUT:
                index, entry = joined.instruction_output(at)
                outputs[index][0][entry] = memory[joined.instruction_input(at)[0]]
            elif operation == OP_CALL:
                operands = tuple(memory[place] for place in joined.instruction_input(at))
                called = written.nz[at].which_function()
                call, entries = known_calls.setdefault((hash(called), operands), (Call(called, operands), {}))
                stage = graph._last_stage(operands)
                for entry, place in enumerate(joined.instruction_output(at)):
                    if place >= 0:  # of an output that is used
                        if entry not in entries:
                            entries[entry] = graph._add(operation, operands, stage)
                            graph.calls[entries[entry]] = call, entry
                        memory[place] = entries[entry]
            elif operation == OP_INPUT:
                argument, entry = joined.instruction_input(at)
                stage, given = symbols[argument]
                node = memory[joined.instruction_output(at)[0]] = graph._add(operation, (), stage)
                graph.given[node] = given.nz[entry]
            elif operation == OP_CONST:
                node = memory[joined.instruction_output(at)[0]] = graph._add(operation, (), -1)
                graph.given[node] = SX(joined.instruction_constant(at))
            else:
                operands = tuple(memory[place] for place in joined.instruction_input(at))
                known_node = known_nodes.get((operation, operands))
                if known_node is None:
                    stage = graph._last_stage(operands)
                    known_node = known_nodes[operation, operands] = graph._add(operation, operands, stage)
                memory[joined.instruction_output(at)[0]] = known_node
        graph._divide()
        return graph

    def _last_stage(self, operands: tuple[int, ...]) -> int:
        """The last stage of these operands, in which what is computed from them can be computed."""
        last = 0
        for each in operands:
            last = max(last, self.stage[each])
        return last

    def _add(self, operation: int, operands: tuple[int, ...], stage: int) -> int:
        """A new node that can be computed in a stage."""
        self.nodes.append((operation, operands))
        self.stage.append(stage)
        return len(self.nodes) - 1

    def _divide(self) -> None:
        """Find which nodes are passed on, and which ones only deferred expressions need."""
        computed = set[int]()
        for k, group in enumerate(self.results):
            for node in (node for nodes in group for node in nodes):
                computed.add(node)
                self._use(node, k)
        for node in self._backwards(computed):
            for operand in self.nodes[node][1]:
                computed.add(operand)
                self._use(operand, self.stage[node])
        evaluated = {self.calls[node][0] for node in computed if node in self.calls}
        computed |= {node for node, (call, _) in self.calls.items() if call in evaluated}  # with all its results
        self.computed = sorted(computed)
        for group in self.deferred:
            wanted = {node for nodes in group for node in nodes}
            for node in self._backwards(wanted, but=computed):
                wanted.update(self.nodes[node][1])
            self.used_later |= {node for node in wanted if node in computed and node not in self.given}
            self.only_deferred.append(sorted(wanted - computed))

    def _backwards(self, wanted: set[int], but: Set[int] = frozenset()) -> Iterator[int]:
        """The nodes of a set that grows meanwhile, the last first; one of those of a call, whose operands are the same.

        Args:
            wanted: the set.
            but: nodes that are left out.
        """
        calls = set[Call]()
        for node in reversed(range(len(self.nodes))):
            if node not in wanted or node in but:
                continue
            call, _ = self.calls.get(node, (None, 0))
            if call is None:
                yield node
            elif call not in calls:
                calls.add(call)
                yield node

    def _use(self, node: int, stage: int) -> None:
        """Note that a stage needs a node; symbols and constants are available in every stage."""
        if node not in self.given and self.stage[node] < stage:
            self.used_later.add(node)

    def evaluate(self, nodes: Sequence[int], values: dict[int, Expression]) -> None:
        """Add the values of these nodes to the values that are given."""
        values |= self.given
        results: dict[Call, list[Expression]] = {}
        for node in nodes:
            operation, operands = self.nodes[node]
            if node in values:
                continue
            if node in self.calls:
                call, entry = self.calls[node]
                if call not in results:
                    results[call] = call.results(values)
                values[node] = results[call][entry]
            elif len(operands) == 1:
                values[node] = SX.unary(operation, values[operands[0]])
            else:
                values[node] = SX.binary(operation, values[operands[0]], values[operands[1]])


def _paired(
    nodes: Sequence[Sequence[list[int]]], expressions: Sequence[Sequence[Expression]]
) -> Iterator[tuple[list[int], Expression]]:
    """The nodes of each expression with the expression."""
    for group, own in zip(nodes, expressions, strict=True):
        yield from zip(group, own, strict=True)


def filled(like: Expression, nodes: Sequence[int], values: dict[int, Expression]) -> Expression:
    """The dense, column-major matrix of these nodes with the shape of ``like``.

    Args:
        like: an expression of that shape.
        nodes: a node for each entry.
        values: the values of the nodes.
    """
    rows, columns = like.shape
    if not nodes:
        return SX.zeros(rows, columns)
    column = vertcat(*[values[node] for node in nodes])
    return column.reshape((rows, columns))
