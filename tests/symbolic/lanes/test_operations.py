"""The operations of a function in lanes are fewer than CasADi's, and have the same values."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

from jtik.symbolic import function, if_else, logic_and, logic_not, logic_or, sqrt, sumsqr, symbol, vertcat
from jtik.symbolic.lanes.operations import operations
from jtik.symbolic.lanes.source import has_lanes

from ...conftest import slow
from .test_source import HIGHEST, SPECIAL, in_lanes


def names(f):
    return [each.name for each in operations(f)]


def same_as_casadi(f, columns, **tolerance):
    expected = np.array([np.array(f(*column)).ravel() for column in columns])
    np.testing.assert_allclose(in_lanes(f, HIGHEST, columns), expected, **tolerance)


@pytest.fixture
def xy():
    return symbol("x", 1), symbol("y", 1)


PAIRS = np.array([(x, y) for x in SPECIAL for y in SPECIAL])


def test_what_a_mask_picks_is_one_choice(xy):
    x, y = xy
    f = function("f", [x, y], [if_else(x < y, x + 1, y)])
    assert names(f).count("CHOOSE") == 1
    assert not {"IF_ELSE_ZERO", "NOT"} & {*names(f)}
    same_as_casadi(f, PAIRS, rtol=0)


def test_the_masks_of_a_choice_may_come_in_either_order_and_its_parts_be_used_elsewhere(xy):
    x, y = xy
    below = x < y
    not_below = logic_not(below)
    one, other = if_else(below, 2 * x, 0), if_else(not_below, y, 0)
    f = function("f", [x, y], [vertcat(other + one, one, one + one, if_else(y < x, x, 0) + one)])
    assert names(f).count("CHOOSE") == 1
    same_as_casadi(f, PAIRS, rtol=0)


def test_truth_values_stay_masks(xy):
    x, y = xy
    beyond = if_else(x >= 1, y > 0, y < 0)
    f = function("f", [x, y], [if_else(logic_and(logic_or(x >= 1, x <= -1), beyond), x * y, 0)])
    numbers = {"ADD", "NE", "CHOOSE"} & {*names(f)}
    assert not numbers
    assert names(f).count("IF_ELSE_ZERO") == 1
    same_as_casadi(f, PAIRS, rtol=0)


def test_a_number_of_masks_is_a_sum(xy):
    x, y = xy
    f = function("f", [x, y], [(x < 1) + (y < 1) + (x < y)])
    assert names(f).count("ADD") == 2
    same_as_casadi(f, PAIRS, rtol=0)


def test_squares_are_fused_into_sums(xy):
    x, y = xy
    f = function("f", [x, y], [sqrt(sumsqr(vertcat(x, y, x + y, x - y)))])
    assert names(f).count("FMA") == 3
    same_as_casadi(f, np.random.default_rng(0).normal(size=(8, 2)), rtol=1e-14)


def test_the_difference_of_equal_products_is_zero(xy):
    x, y = xy
    f = function("f", [x, y], [(x * y) * y - x * (y * y)])
    assert not {"FMA", "FMS", "FNMA"} & {*names(f)}
    points = np.random.default_rng(0).normal(size=(8, 1)) * [1.0, 0.0] + [0.0, 0.3]
    g = function("g", [x, y], [x * y - y * x + (x * x - x * x)])
    assert (in_lanes(g, HIGHEST, points) == 0).all()


@pytest.mark.parametrize("seed", [*range(4), *slow(*range(4, 24))])
def test_functions_made_at_random(seed):
    """Numbers and truth values in any place, some of them used several times."""
    generator = np.random.default_rng(seed)
    x, y = symbol("x", 1), symbol("y", 1)
    numbers, truths = [x, y, casadi.SX(1.5), casadi.SX(0), casadi.SX(-1)], [x < y]
    pick = lambda of: of[generator.integers(max(len(of) - 12, 0), len(of))]  # noqa: E731
    for _ in range(60):
        a, b, m, n = pick(numbers), pick(numbers), pick(truths), pick(truths)
        made = generator.integers(14)
        if made < 8:
            new = [a + b, a - b, a * b, a * a, if_else(m, a, b), if_else(m, a, 0), m + n, a * m][made]
            numbers.append(new / 2)
        else:
            both = [a < b, a <= b, logic_and(m, n), logic_or(m, n), logic_not(m), if_else(m, n, a < b)]
            truths.append(both[made - 8])
    f = function("f", [x, y], [vertcat(*numbers[-10:], *truths[-10:])])
    assert has_lanes(f)
    points = generator.integers(-3, 4, size=(64, 2)) / 2.0  # equal ones among them
    same_as_casadi(f, points, rtol=1e-12, atol=1e-12)
