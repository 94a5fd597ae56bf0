"""The small operations built on CasADi: values, and derivatives that are finite everywhere."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

import jtik.symbolic as sym


def evaluate(expression, *pairs):
    """The expression as numbers, for (symbol, value) pairs."""
    symbols, values = zip(*pairs, strict=True)
    return casadi.Function("f", list(symbols), [casadi.densify(expression)])(*values).full()


def test_every_exported_name_exists_and_is_listed_in_the_docstring():
    for name in sym.__all__:
        assert hasattr(sym, name)
        assert f"`{name}`" in sym.__doc__


def test_norm_and_its_gradient():
    v = sym.symbol("v", 3)
    length, derivative = sym.norm(v), sym.gradient(sym.norm(v), v)
    assert evaluate(length, (v, [3.0, 0.0, 4.0])) == 5.0
    assert evaluate(derivative, (v, [3.0, 0.0, 4.0]))[:, 0] == pytest.approx([0.6, 0.0, 0.8])
    assert evaluate(derivative, (v, [0.0, 0.0, 0.0]))[:, 0].tolist() == [0, 0, 0]


def test_zero_divided_by_zero_is_zero():
    x, y = sym.symbol("x", 1), sym.symbol("y", 1)
    assert evaluate(sym.ratio(x, y), (x, 0.0), (y, 0.0)) == 0.0
    assert evaluate(sym.ratio(x, y), (x, 3.0), (y, 2.0)) == 1.5


@pytest.mark.parametrize(
    ("value", "finite"), [([1.0, -2.0], 1), ([np.nan, 0.0], 0), ([0.0, np.inf], 0), ([-np.inf, np.inf], 0)]
)
def test_is_finite(value, finite):
    v = sym.symbol("v", 2)
    assert evaluate(sym.is_finite(v), (v, value)) == finite


def test_solve_ldl_solves_a_positive_definite_system(rng):
    A, b = sym.symbol("A", 4, 4), sym.symbol("b", 4)
    root, right = rng.normal(size=(4, 4)), rng.normal(size=4)
    matrix = root @ root.T + np.eye(4)
    found = evaluate(sym.solve_ldl(A, b), (A, matrix), (b, right))[:, 0]
    assert found == pytest.approx(np.linalg.solve(matrix, right), rel=1e-10)


def test_gram_is_the_product_with_the_transpose(rng):
    M, w = sym.symbol("M", 3, 4), sym.symbol("w", 3)
    matrix, weights = rng.normal(size=(3, 4)), rng.normal(size=3)
    assert evaluate(sym.gram(M), (M, matrix)) == pytest.approx(matrix.T @ matrix)
    weighted = evaluate(sym.gram(M, w), (M, matrix), (w, weights))
    assert weighted == pytest.approx(matrix.T @ np.diag(weights) @ matrix)
    assert (weighted == weighted.T).all()


def test_stack_makes_a_matrix_from_rows():
    x = sym.symbol("x", 1)
    assert evaluate(sym.stack([[x, 2], [3, x**2]]), (x, 5.0)).tolist() == [[5, 2], [3, 25]]


def test_numbers_of_a_matrix_without_symbols():
    assert sym.numbers(casadi.SX([[1, 2], [3, 4]])).tolist() == [[1, 2], [3, 4]]
    assert sym.numbers(sym.symbol("x", 2)) is None


def test_hessian():
    v = sym.symbol("v", 2)
    assert evaluate(sym.hessian(v[0] ** 2 * v[1], v), (v, [2.0, 3.0])).tolist() == [[6, 4], [4, 0]]


def test_float_of_an_expression_raises_while_a_criterion_is_traced():
    x = sym.symbol("x", 1)
    with sym.no_silent_float(), pytest.raises(TypeError, match="a number is needed, and the value is an expression"):
        float(x)
    with sym.no_silent_float():
        assert float(casadi.SX(2.5)) == 2.5


def test_numpy_norm_is_smooth_while_a_criterion_is_traced():
    v = sym.symbol("v", 2)
    with sym.smooth_numpy_norm():
        derivative = sym.gradient(np.linalg.norm(v), v)
    assert evaluate(derivative, (v, [0.0, 0.0]))[:, 0].tolist() == [0, 0]
