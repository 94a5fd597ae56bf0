"""Matrix operations in generated C as few loops: the same bits as on the virtual machine, whatever follows what."""

from __future__ import annotations

import re

import casadi
import numpy as np
import pytest

from jtik.symbolic import c_source
from jtik.symbolic.compile import CompilerError, bind, compiler, to_c
from jtik.symbolic.generated_c.fused_loops import LARGE, SHORT

N = 70
"""Entries of a vector: more than `LARGE`."""


@pytest.fixture
def a_compiler(tmp_path, monkeypatch):
    try:
        compiler()
    except CompilerError:
        pytest.skip("needs a C compiler")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))


def inner(size):
    """A function that stays a call, with two outputs."""
    x, y = casadi.MX.sym("x", size), casadi.MX.sym("y", size)
    outputs = [casadi.fmax(x, y) * 2 - y, casadi.sum1(x * y)]
    return casadi.Function("inner", [x, y], outputs, {"never_inline": True})


def operation(rng, pool, numbers, size):
    """A random operation on vectors and numbers of the pools, which gets its result."""
    a, b, c = (pool[i] for i in rng.integers(len(pool), size=3))
    number = numbers[rng.integers(len(numbers))]
    wide = casadi.vertcat(a, b, c)
    begin = int(rng.integers(2 * size + 1))
    choices = [
        lambda: a + b,
        lambda: a - b,
        lambda: a * b,
        lambda: casadi.fmin(a, b),
        lambda: casadi.fmax(number, a),
        lambda: a < b,
        lambda: casadi.logic_not(a <= number),
        lambda: casadi.if_else(a < b, c, number),
        lambda: casadi.logic_and(a < b, c <= number),
        lambda: casadi.logic_or(a < number, casadi.logic_not(c)),
        lambda: -a,
        lambda: number * a,
        lambda: a / (1 + b * b),
        lambda: wide[begin : begin + size],
        lambda: a[::-1],
        lambda: casadi.mtimes(casadi.horzcat(a, b), casadi.vertcat(number, 2)),
        lambda: inner(size)(a, b)[0],
        lambda: casadi.fabs(casadi.sqrt(casadi.fabs(a))),
        lambda: casadi.MX.ones(size, 1) * number,
    ]
    pool.append(choices[rng.integers(len(choices))]())
    more = [casadi.dot(a, b), number * 0.5, casadi.fmin(number, 2), a[3], casadi.norm_inf(a), inner(size)(a, b)[1]]
    if rng.random() < 0.4:
        numbers.append(more[rng.integers(len(more))])


def random_function(seed, size):
    """A function of a vector, a matrix and a number, some of whose outputs are the same or an input."""
    rng = np.random.default_rng(seed)
    x, A, t = casadi.MX.sym("x", size), casadi.MX.sym("A", size, 3), casadi.MX.sym("t")
    pool, numbers = [x, A[:, 1], casadi.mtimes(A, casadi.vertcat(t, 1, t))], [t, casadi.MX(0.5)]
    for _ in range(int(rng.integers(4, 40))):
        operation(rng, pool, numbers, size)
    chosen = [pool[i] for i in rng.integers(len(pool), size=4)]
    outputs = [*chosen, casadi.horzcat(chosen[0], pool[-1], pool[-2]), numbers[-1], chosen[1]]
    return casadi.Function("graph", [x, A, t], outputs, {"cse": bool(rng.integers(2))})


@pytest.mark.quick(3)
@pytest.mark.parametrize("size", [SHORT - 1, SHORT, 33, LARGE, N, 640])
@pytest.mark.parametrize("seed", range(20))
def test_the_bits_are_those_of_the_virtual_machine(seed, size, a_compiler, rng):
    """For all outputs, and where some are not asked for; an input has NaN and infinity in it."""
    machine = random_function(seed, size)
    compiled = to_c(machine)
    given = [rng.normal(size=size), rng.normal(size=3 * size), rng.normal(size=1)]
    for value in (0.5, np.nan, np.inf):
        given[0][1] = value
        for left_out in (None, 0, 1, 4):
            results = []
            for each in (machine, compiled):
                memory = [np.full(each.numel_out(i), 9.0) for i in range(each.n_out())]
                if left_out is not None:
                    memory[left_out] = np.zeros(0)
                bind(each, given, memory)()
                bind(each, given, memory)()  # again: nothing is left of the first call
                results.append(memory)
            for one, other in zip(*results, strict=True):
                np.testing.assert_array_equal(one, other)


def written(function):
    """Its generated C, without comments."""
    return re.sub(r"/\*.*\*/\n", "", c_source(function))


def test_operations_that_follow_one_another_are_one_loop():
    x, y = casadi.MX.sym("x", N), casadi.MX.sym("y", N)
    code = written(casadi.Function("graph", [x, y], [casadi.fmax(x * y, 0) - casadi.fmin(x, y), x * y + 1]))
    assert code.count("JTIK_INDEPENDENT\n    for") == 1
    assert "rr" not in code.split("JTIK_INDEPENDENT\n")[-1]


def test_a_result_that_nothing_reads_is_not_written():
    x, y = casadi.MX.sym("x", N), casadi.MX.sym("y", N)
    code = written(casadi.Function("graph", [x, y], [(x * y - x) * (x + y)]))
    loop = code[code.index("JTIK_INDEPENDENT\n    for") :]
    assert len(re.findall(r"^      \w+\[i\] = ", loop[: loop.index("\n    }")], re.MULTILINE)) == 1


def test_a_large_output_is_computed_where_it_belongs():
    """A matrix of many rows is not copied; a small one is."""
    x, A = casadi.MX.sym("x", N), casadi.MX.sym("A", 3, N)
    large = casadi.Function("graph", [x, A], [casadi.mtimes(x, casadi.mtimes(A, x).T)])
    assert re.search(r"if \(res\[0\]\) w\d+ = res\[0\];", written(large))
    assert "res[0]);" not in written(large)
    small = casadi.Function("graph", [x, A], [casadi.mtimes(A, x)])
    assert "res[0]);" in written(small)


def test_what_changes_after_it_is_an_output_stays_where_it_is(a_compiler, rng):
    """A vector whose memory is used again is copied."""
    x = casadi.MX.sym("x", N)
    first = x[::-1] * 2
    later = first
    for _ in range(6):
        later = casadi.fmin(later[::-1], x) - 0.1
    machine = casadi.Function("graph", [x], [first, later], {"cse": False})
    compiled, given = to_c(machine), rng.normal(size=N)
    for one, other in zip(machine(given), compiled(given), strict=True):
        np.testing.assert_array_equal(np.array(one), np.array(other))


def test_short_loops_stay_as_they_are():
    x = casadi.MX.sym("x", SHORT - 1)
    assert "JTIK_INDEPENDENT\n    for" not in written(casadi.Function("graph", [x], [x * x - x]))


def test_a_number_whose_memory_is_used_again_has_its_value_of_then(a_compiler, rng):
    x, y = casadi.MX.sym("x", N), casadi.MX.sym("y", N)
    chosen = casadi.if_else(x < 0.25, casadi.fmin(x, 0.125), casadi.fmax(y, -0.5)) * 3
    machine = casadi.Function("graph", [x, y], [casadi.fmin(chosen, 1.5) - casadi.fmax(y, 0.75)])
    code = written(machine)
    numbers = re.findall(r"^    (w\d+) = ", code, re.MULTILINE)
    assert len(numbers) > len(set(numbers))  # memory is used again
    compiled, given = to_c(machine), rng.normal(size=(2, N))
    np.testing.assert_array_equal(np.array(compiled(*given)), np.array(machine(*given)))
