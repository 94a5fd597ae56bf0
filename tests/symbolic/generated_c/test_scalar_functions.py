"""Functions of scalar operations in generated C, rewritten: the bits of CasADi's own text, however it is cut."""

from __future__ import annotations

import re

import casadi
import numpy as np
import pytest

from jtik.symbolic import looped, symbol
from jtik.symbolic.compile import CompiledFunction, CompilerError, bind, compiler, to_c
from jtik.symbolic.generated_c import SELDOM, c_source
from jtik.symbolic.generated_c.scalar_functions import PART, with_scalar_functions_rewritten

try:
    compiler()
except CompilerError:
    pytest.skip("needs a C compiler", allow_module_level=True)

SIZE = 6


def product(A, b):
    """What a call returns."""
    return (A @ A @ b,)


def example(*, calls=False, name="example"):
    """Some thousand operations, among them all that a step is made of; with calls of other functions between them."""
    x, y = symbol("x", SIZE), symbol("y", SIZE)
    A = casadi.reshape(casadi.sin(casadi.kron(x, y)), SIZE, SIZE)
    product_now = looped(product, A, y, when=calls)[0]
    limited = casadi.fmax(casadi.fmin(product_now, 1 / (1 + x**2)), -casadi.fabs(y))
    chosen = casadi.if_else(casadi.logic_and(x > 0, y <= x), limited, casadi.sqrt(casadi.fabs(product_now)) - 0.25)
    again = looped(product, A + 1, chosen, when=calls)[0]
    return casadi.Function(name, [x, y], [A, chosen, casadi.sumsqr(again) + casadi.cos(x[0])])


def cut(monkeypatch, longest, part):
    """From here on functions that are longer are cut into parts of so many statements."""
    monkeypatch.setattr(
        "jtik.symbolic.generated_c.source.with_scalar_functions_rewritten",
        lambda source: with_scalar_functions_rewritten(source, longest, part),
    )


def original(monkeypatch):
    """From here on functions are as CasADi generates them."""
    monkeypatch.setattr("jtik.symbolic.generated_c.source.with_scalar_functions_rewritten", lambda source: source)


def same_bits(found, expected):
    return all(one.tobytes() == other.tobytes() for one, other in zip(found, expected, strict=True))


@pytest.mark.parametrize("calls", [False, True])
@pytest.mark.parametrize(("longest", "part"), [(10**6, PART), (100, 1), (100, 7), (100, 10**6)])
def test_the_same_bits(longest, part, calls, monkeypatch, rng):
    f = example(calls=calls)
    with monkeypatch.context() as patch:
        original(patch)
        before = CompiledFunction(to_c(f))
    cut(monkeypatch, longest, part)
    after = CompiledFunction(to_c(f))
    for _ in range(20):
        given = rng.normal(size=(2, SIZE))
        assert same_bits(after(*given), before(*given))


def test_the_text_is_rewritten_and_cut(monkeypatch):
    f = example(calls=True)
    with monkeypatch.context() as patch:
        original(patch)
        before = c_source(f)
    cut(monkeypatch, 100, 50)
    after = c_source(f)
    for test_of_each_entry in ("? arg[0][", "!=0) res["):
        assert test_of_each_entry in before
        assert test_of_each_entry not in after
    longest = max(len(body.split("\n")) for body in re.findall(r"^JTIK_PART static .*?^}", after, re.M | re.S))
    assert 50 < longest < 2 * 50 + 50  # its statements, what it reads and keeps for others, and its inputs and outputs


def test_a_function_of_few_statements_stays_whole():
    assert "JTIK_PART static" not in c_source(example())


@pytest.mark.parametrize(("longest", "part"), [(10**6, PART), (10, 5)])
def test_inputs_and_outputs_that_are_not_given(longest, part, monkeypatch, rng):
    """An input without memory is zero, and an output without memory is not written."""
    cut(monkeypatch, longest, part)
    x, y = symbol("x", SIZE), symbol("y", SIZE)
    made = to_c(casadi.Function("inner", [x, y], [casadi.sin(x) * casadi.cos(y), x + y]))
    given, found = rng.normal(size=SIZE), np.zeros(SIZE)
    nothing = np.zeros(0)
    bind(made, [given, nothing], [found, nothing])()
    assert found == pytest.approx(np.sin(given), abs=1e-15)
    bind(made, [nothing, given], [nothing, found])()
    assert found.tolist() == given.tolist()


def test_parts_of_what_is_seldom_needed_are_not_optimised_either(monkeypatch):
    cut(monkeypatch, 100, 50)
    x, y = casadi.MX.sym("x", SIZE), casadi.MX.sym("y", SIZE)
    seldom = casadi.Function("outer", [x, y], example(name=f"{SELDOM}example").call([x, y], False, True))
    source = c_source(seldom)
    parts = re.findall(r"^(\w+) static int casadi_f\d+_\d+\(", source, re.M)
    assert len(parts) > 5
    assert set(parts) == {"JTIK_SELDOM"}


@pytest.mark.parametrize(
    "line", ["  a1=arg[0][2];  /* new */ goto end;", "  casadi_copy(w, 3, res[0]);", "  if (a1) {"]
)
def test_a_function_with_other_statements_is_left_alone(line, monkeypatch):
    original(monkeypatch)
    source = c_source(example())
    before = source.replace("  return 0;\n}", f"{line}\n  return 0;\n}}", 1)
    assert before != source
    assert with_scalar_functions_rewritten(before, 100, 50) == before


def test_variables_are_kept_in_places_that_are_used_again(monkeypatch, rng):
    """An array as long as what has to be kept at one time, not as all that is ever kept."""
    cut(monkeypatch, 100, 10)
    x = symbol("x", 1)
    chain = [x]
    for first, second in rng.permuted([[casadi.sin, casadi.cos]] * 250 + [[casadi.fabs, casadi.sqrt]] * 250, axis=1):
        chain.append(first(chain[-1]) + second(chain[-1]))
    source = c_source(casadi.Function("chain", [x], [chain[-1]]))
    assert int(re.search(r"casadi_real v\[(\d+)\];", source)[1]) <= 5
