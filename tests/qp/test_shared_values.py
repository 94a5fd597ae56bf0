"""Groups of expressions as functions: the same numbers, and what several groups need is computed once, before them."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

from jtik.qp.shared_values import divided
from jtik.symbolic import function, symbol
from jtik.symbolic.compile import CompiledFunction

from ..conftest import EXACT

COSTLY = (casadi.OP_SIN, casadi.OP_COS, casadi.OP_EXP, casadi.OP_SQRT)


def example():
    """Three groups: a sine that two of them need, a root that is one's own, an input and a constant as they are."""
    a, b = symbol("a", 2), symbol("b", 2)
    sine = casadi.sin(a[0] + b[1])
    groups = [
        casadi.vertcat(sine * b[0], sine * casadi.exp(a[1])),
        casadi.vertcat(sine, casadi.sqrt(1 + b[0] ** 2), a[1]),
        casadi.vertcat(2.0, casadi.cos(a[0])),
    ]
    return [a, b], groups


def results(inputs, groups, numbers):
    shared, own = divided("example", inputs, groups)
    values = CompiledFunction(shared)(*numbers)[0]
    return [CompiledFunction(each)(*numbers, values)[0] for each in own]


def test_the_same_numbers(rng):
    inputs, groups = example()
    for numbers in rng.uniform(-1, 1, (5, 2, 2)):
        expected = CompiledFunction(casadi.Function("all", inputs, groups))(*numbers)
        for mine, its in zip(results(inputs, groups, numbers), expected, strict=True):
            assert mine == pytest.approx(its, abs=EXACT)


def counts(made):
    """How often a function calls each costly operation."""
    return [sum(made.instruction_id(i) == each for i in range(made.n_instructions())) for each in COSTLY]


def test_what_several_need_is_computed_once_and_the_rest_in_its_group():
    shared, own = divided("example", *example())
    assert [counts(each) for each in (shared, *own)] == [[1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1], [0, 1, 0, 0]]
    assert shared.numel_out(0) == 1


def test_a_call_stays_in_its_group_unless_several_need_one_of_its_results(rng):
    x = symbol("x", 2)
    inner = function("inner", [x], [casadi.sin(x[0]), casadi.cos(x[1])], inline=False)
    a, b, numbers = symbol("a", 2), symbol("b", 2), rng.uniform(-1, 1, (2, 2))
    first, second, third = (inner.call([each]) for each in (a, b, a + b))
    groups = [first[0] + first[1], second[0], second[1] * third[0], third[0] + third[1]]
    _, own = divided("example", [a, b], groups)
    calls = [sum(each.instruction_id(i) == casadi.OP_CALL for i in range(each.n_instructions())) for each in own]
    assert calls == [1, 0, 0, 0]
    expected = CompiledFunction(casadi.Function("all", [a, b], groups))(*numbers)
    assert np.ravel(results([a, b], groups, numbers)) == pytest.approx(np.ravel(expected), abs=EXACT)


def test_nothing_is_shared():
    a = symbol("a", 2)
    shared, own = divided("example", [a], [casadi.sin(a[0]), casadi.cos(a[1])])
    assert shared.numel_out(0) == 0
    assert CompiledFunction(own[1])(np.ones(2), [])[0].item() == pytest.approx(np.cos(1.0))
