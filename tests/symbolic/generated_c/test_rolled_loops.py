"""Statements that repeat as loops: the bits of CasADi's own text, whatever repeats, and a text that does not grow."""

from __future__ import annotations

import re

import casadi
import numpy as np
import pytest

from jtik.symbolic import looped
from jtik.symbolic.compile import CompiledFunction, CompilerError, compiler, to_c
from jtik.symbolic.generated_c import c_source, rolled_loops
from jtik.symbolic.generated_c.repeated_statements import REPEATED, alike
from jtik.symbolic.generated_c.rolled_loops import MOST_KEPT
from jtik.symbolic.generated_c.rolled_loops import rolled as rolled_within

try:
    compiler()
except CompilerError:
    pytest.skip("needs a C compiler", allow_module_level=True)


def sums(A, b):
    """What a call returns."""
    return (A @ b, casadi.fmax(b, 0.5))


def shifted(values, by):
    return values[by:] + values[:by]


def random_function(seed, rows):
    """A function of columns with operations of each row, of neighbours, along all rows, and of a call between them."""
    rng = np.random.default_rng(seed)
    x, y = casadi.SX.sym("x", rows), casadi.SX.sym("y", rows, 3)
    number = casadi.SX.sym("number")
    columns = [casadi.vertsplit(each) for each in (x, y[:, 0], y[:, 2])]
    single = [number, casadi.SX(0.5)]
    for _ in range(int(rng.integers(3, 14))):
        a, b, c = (columns[i] for i in rng.integers(len(columns), size=3))
        one = single[rng.integers(len(single))]
        kind = int(rng.integers(9))
        if kind == 0:
            columns.append([p * q - one for p, q in zip(a, b, strict=True)])
        elif kind == 1:
            columns.append([casadi.if_else(p < q, r, one) for p, q, r in zip(a, b, c, strict=True)])
        elif kind == 2:
            columns.append([casadi.fmin(p, one) + casadi.sin(q) for p, q in zip(a, b, strict=True)])
        elif kind == 3:  # along the rows, from one to the next
            sums_so_far, total = [], one
            for p in a:
                total = casadi.fmax(total, p) * 0.75
                sums_so_far.append(total)
            columns.append(sums_so_far)
        elif kind == 4:
            total = one
            for p, q in zip(a, b, strict=True):
                total = casadi.fmax(total, casadi.if_else(p < q, p, 0))
            single.append(total)
        elif kind == 5:  # of neighbours
            columns.append([p + q * one for p, q in zip(a, shifted(b, int(rng.integers(1, 4))), strict=True)])
        elif kind == 6:
            columns.append(a[::-1])
        elif kind == 7:
            columns.append([p / (1 + p**2) if i % 3 else -p for i, p in enumerate(a)])
        else:
            found, most = looped(sums, casadi.horzcat(*map(casadi.vcat, (a, b))).T, casadi.vcat(c))
            single.append(found[0] + found[1])
            columns.append(casadi.vertsplit(most))
    chosen = [columns[i] for i in rng.integers(len(columns), size=4)]
    table = casadi.horzcat(*map(casadi.vcat, chosen[:3]), number * casadi.SX.ones(rows))
    outputs = [table.T if rng.integers(2) else table, casadi.vcat(chosen[3]), single[-1], chosen[0][rows // 2]]
    return casadi.Function("example", [x, y, number], outputs, {"cse": bool(rng.integers(2))})


@pytest.mark.quick(3)
@pytest.mark.parametrize("rows", [REPEATED - 1, REPEATED + 1, 100])
@pytest.mark.parametrize("seed", range(30))
def test_the_same_bits(seed, rows, rng, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    function = random_function(seed, rows)
    after = CompiledFunction(to_c(function))
    with monkeypatch.context() as patch:
        patch.setattr("jtik.symbolic.generated_c.source.with_scalar_functions_rewritten", lambda source: source)
        before = CompiledFunction(to_c(function))
    for value in (0.5, np.nan, np.inf, -0.0):
        given = [rng.normal(size=rows), rng.normal(size=(rows, 3)), rng.normal(size=1)]
        given[0][rows // 3] = value
        for _ in range(2):  # nothing is left of the first call
            for one, other in zip(after(*given), before(*given), strict=True):
                np.testing.assert_array_equal(one, other)
                np.testing.assert_array_equal(np.signbit(one[one == 0]), np.signbit(other[other == 0]))


def text_of(rows):
    """C of what a program computes for each row, and of the largest of them."""
    x, y, t = casadi.SX.sym("x", rows), casadi.SX.sym("y", rows), casadi.SX.sym("t")
    bound = casadi.fmin(x - t * (y < x), y)
    return c_source(casadi.Function("example", [x, y, t], [bound, casadi.mmax(bound)]))


def test_the_text_does_not_grow_with_the_rows():
    assert len(text_of(70).split("\n")) == pytest.approx(len(text_of(400).split("\n")), abs=2)


def test_a_loop_without_an_order_is_said_to_have_none():
    """Vector instructions are for rows that do not depend on each other."""
    rows = REPEATED + 6
    x, y = casadi.SX.sym("x", rows), casadi.SX.sym("y", rows)
    assert "    JTIK_INDEPENDENT\n" in c_source(casadi.Function("example", [x, y], [x * y - x]))
    total = casadi.SX(0)
    for each in casadi.vertsplit(x):
        total = casadi.fmax(total, each)
    source = c_source(casadi.Function("example", [x], [total]))
    assert re.search(r"c0 = b\d+;", source)
    assert "    JTIK_INDEPENDENT\n" not in source


def lines(text):
    return [f"  {line}" for line in text]


def rolled(lines):
    return rolled_within(lines, 10**6)


def test_what_stays_too_long_is_left_to_others():
    """It is divided: that needs all statements."""
    alone = [f"a{i % 5}=(x0[{i * i}]+x1[{i}]);" if i % 2 else f"a{i % 3}=(x1[{i}]*x0[{i}]);" for i in range(300)]
    block = [f"y0[{i}]=x0[{i}];" for i in range(REPEATED)]
    assert rolled_within(lines([*alone, *block]), 400) is not None
    assert rolled_within(lines([*alone, *block]), 290) is None


def test_what_does_not_repeat_stays():
    assert rolled(lines(f"a{i % 5}=(x0[{i * i}]+x1[{i}]);" for i in range(200))) is None
    assert rolled(lines(f"a0=(x0[{i}]+x1[{i}]);" for i in range(REPEATED - 1))) is None


def test_what_a_loop_computes_is_read_after_it():
    """The last value in a variable, others in an array; an entry of another stride in the same loop."""
    block = [line for i in range(REPEATED) for line in (f"a1=(x0[{i}]*x1[{3 * i + 2}]);", f"y0[{2 * i}]=a1;")]
    last = rolled(lines([*block, "y1[0]=a1;"]))
    assert re.search(r"y1\[0\]=t\d+_0;", last)
    assert "x1[2+3*i]" in last
    assert "y0[0+2*i]" in last
    each = rolled(lines([*(f"a{i}=(x0[{i}]*x0[{i}]);" for i in range(REPEATED)), "y1[0]=(a3+a7);"]))
    assert re.search(r"y1\[0\]=\(t\d+_0\[3\]\+t\d+_0\[7\]\);", each)


def test_what_repeats_too_seldom_takes_no_time():
    """Tables of fewer rows than a loop has, and of many columns: the time grows with their entries."""
    seldom = lines(
        f"y0[{1000 * column + i}]=(x0[{1000 * column + i}]*x1[{i}]);"
        for column in range(400)
        for i in range(REPEATED - 1)
    )
    operands = 0
    with pytest.MonkeyPatch.context() as patch:

        def counted(*given):
            nonlocal operands
            operands += 1
            return alike(*given)

        patch.setattr(rolled_loops, "alike", counted)
        assert rolled(seldom) is None
    assert operands < 100 * len(seldom)


def test_arrays_do_not_fill_the_stack():
    rows = MOST_KEPT // 2 + 1
    loops = [f"a{k * rows + i}=(x0[{i}]*x1[{k}]);" for k in range(2) for i in range(rows)]
    read = [f"y0[{k}]=(a{k * rows}+a{k * rows + 3});" for k in range(2)]
    assert rolled(lines([*loops[:rows], *read[:1]])) is not None
    assert rolled(lines([*loops, *read])) is None


def test_a_call_divides_loops():
    block = lines(f"w[{i}]=x0[{i}];" for i in range(2 * REPEATED))
    whole, call = rolled(block), "  if (casadi_f3(arg, res, iw, w, 0)) return 1;"
    divided = rolled([*block[:REPEATED], call, *block[REPEATED:]])
    assert whole.count("for (") == 1
    assert divided.count("for (") == 2
    assert divided.index("for (") < divided.index(call) < divided.rindex("for (")
