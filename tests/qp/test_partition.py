"""Partition of an expression graph into stages: the same values, each computed once."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

from jtik.qp.partition import partitioned
from jtik.symbolic import looped, symbol
from jtik.symbolic.compile import CompiledFunction

from ..conftest import EXACT


def run(stages, known):
    """The results of the stages, called in order as in `jtik.qp.staged`."""
    arguments, given = list(known[0]), []
    for k, stage in enumerate(stages):
        *outputs, intermediate = [*CompiledFunction(stage)(*arguments), None][: stage.n_out() + (k == len(stages) - 1)]
        given.append(outputs)
        if k < len(stages) - 1:
            arguments += [intermediate, *known[k + 1]]
    return given


def squared(A):
    """What a call returns: the square of a matrix."""
    return (A @ A,)


def example():
    """Three stages, a costly value that all of them use, and outputs that are constant, zero and sparse."""
    a, b, c = symbol("a", 3), symbol("b", 2), symbol("c", 1)
    costly = casadi.exp(casadi.sin(a[0]) * a[1]) + casadi.sqrt(a[2] ** 2 + 1)
    second = costly * b[0] + casadi.if_else(b[1] > 0, b[1], -b[1])
    known = [[a], [b], [c]]
    wanted = [
        [casadi.vertcat(costly, 2.0), casadi.SX(2, 3)],
        [casadi.diag(casadi.vertcat(second, a[0]))],
        [second * c + costly],
    ]
    return known, wanted


def test_the_same_numbers(rng):
    known, wanted = example()
    stages, _ = partitioned(["one", "two", "three"], known, wanted)
    numbers = [[rng.uniform(-1, 1, s.shape[0]) for s in group] for group in known]
    symbols = [s for group in known for s in group]
    flat = [n for group in numbers for n in group]
    for given, expected in zip(run(stages, numbers), wanted, strict=True):
        for mine, expression in zip(given, expected, strict=True):
            assert mine == pytest.approx(casadi.Function("f", symbols, [expression])(*flat).full(), abs=EXACT)


def test_nothing_is_computed_twice():
    known, wanted = example()
    stages, _ = partitioned(["one", "two", "three"], known, wanted)
    transcendental = {casadi.OP_EXP, casadi.OP_SIN, casadi.OP_SQRT}
    counts = [sum(stage.instruction_id(i) in transcendental for i in range(stage.n_instructions())) for stage in stages]
    assert counts == [3, 0, 0]


def test_a_stage_without_intermediate_values():
    a, b = symbol("a", 1), symbol("b", 1)
    (first, last), _ = partitioned(["one", "two"], [[a], [b]], [[a + 1], [b * a]])
    assert first.numel_out(1) == 0
    assert run([first, last], [[2.0], [3.0]])[1][0] == pytest.approx(6.0)


def test_deferred_expressions_are_computed_after_their_stage(rng):
    """What only they need is computed with them, what a stage needs as well is passed on."""
    known, wanted = example()
    (a,), (b,) = known[0], known[1]
    shared, own = casadi.exp(casadi.sin(a[0]) * a[1]), casadi.sqrt(1 + casadi.cos(a[2]) ** 2)
    deferred = [[shared * own, casadi.SX(2.0)], [b * own + shared]]
    stages, after = partitioned(["one", "two", "three"], known, wanted, deferred)
    numbers = [[rng.uniform(-1, 1, s.shape[0]) for s in group] for group in known]
    arguments = list(numbers[0])
    for k, (data, expected) in enumerate(zip(after, deferred, strict=True)):
        *_, intermediate = CompiledFunction(stages[k])(*arguments)
        found = CompiledFunction(data)(*arguments, intermediate)
        flat = [n for group in numbers[: k + 1] for n in group]
        symbols = [s for group in known[: k + 1] for s in group]
        for mine, expression in zip(found, expected, strict=True):
            assert mine == pytest.approx(casadi.Function("f", symbols, [expression])(*flat).full(), abs=EXACT)
        arguments += [intermediate, *numbers[k + 1]]

    def count(of, operation):
        return sum(of.instruction_id(i) == operation for i in range(of.n_instructions()))

    assert [count(each, casadi.OP_COS) for each in (*stages, *after)] == [0, 0, 0, 1, 1]
    assert [count(each, casadi.OP_EXP) for each in (*stages, *after)] == [1, 0, 0, 0, 0]


def test_a_call_is_evaluated_once_for_a_stage_and_what_is_deferred(rng):
    """Its results are passed on, also those that only deferred expressions need; so is what such a call needs."""
    a, b = symbol("a", 4), symbol("b", 2)
    A = casadi.reshape(a, 2, 2)

    def called(matrix):
        return looped(squared, matrix)[0]

    first, second = called(A), called(A + 1)
    known, wanted = [[a], [b]], [[first[0, 0]], [b + second[1, 1]]]
    deferred = [[first[0, 1] + 2 * second[0, 1]]]
    stages, (data,) = partitioned(["one", "two"], known, wanted, deferred)
    x = rng.uniform(-1, 1, 4)
    of_first, of_second = (np.linalg.matrix_power(x.reshape(2, 2).T + shift, 2) for shift in (0, 1))
    wanted_now, intermediate = CompiledFunction(stages[0])(x)
    assert wanted_now == pytest.approx(of_first[0, 0], abs=EXACT)
    assert CompiledFunction(data)(x, intermediate)[0] == pytest.approx(of_first[0, 1] + 2 * of_second[0, 1], abs=EXACT)
    last = CompiledFunction(stages[1])(x, intermediate, [3.0, 4.0])[0].ravel()
    assert last == pytest.approx(np.array([3.0, 4.0]) + of_second[1, 1], abs=EXACT)
    calls = [sum(f.instruction_id(i) == casadi.OP_CALL for i in range(f.n_instructions())) for f in (*stages, data)]
    assert calls == [2, 0, 0]


def test_a_call_that_only_deferred_expressions_need_is_evaluated_with_them(rng):
    a, b = symbol("a", 4), symbol("b", 1)
    root = casadi.sqrt(a)
    power = looped(squared, casadi.reshape(root, 2, 2))[0]
    stages, (data,) = partitioned(["one", "two"], [[a], [b]], [[root[0]], [b]], [[power[1, 0] + power[0, 1]]])
    x = rng.uniform(1, 2, 4)
    *_, intermediate = CompiledFunction(stages[0])(x)
    expected = np.linalg.matrix_power(np.sqrt(x).reshape(2, 2).T, 2)
    assert CompiledFunction(data)(x, intermediate)[0] == pytest.approx(expected[1, 0] + expected[0, 1], abs=EXACT)
    calls = [sum(f.instruction_id(i) == casadi.OP_CALL for i in range(f.n_instructions())) for f in (*stages, data)]
    assert calls == [0, 0, 1]
