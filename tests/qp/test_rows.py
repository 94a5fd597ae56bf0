"""Groups of rows of a QP."""

from __future__ import annotations

import casadi
import pytest

from jtik.qp import Elastic, Rows

MATRIX = casadi.SX([[1, 2, 3], [4, 5, 6]])


def test_equal_rows_have_the_same_expression_as_both_bounds():
    to = casadi.SX.sym("to", 2)
    rows = Rows.equal("task", MATRIX, to)
    assert rows.lower is rows.upper is to
    assert (rows.name, rows.count, rows.elastic) == ("task", 2, None)


@pytest.mark.parametrize("count", [0, 1, 5])
def test_the_count_is_the_number_of_rows(count):
    assert Rows("r", casadi.SX(count, 3), casadi.SX(count, 1), casadi.SX(count, 1)).count == count


def test_equalities_can_be_elastic():
    elastic = Elastic(3.0)
    assert Rows.equal("task", MATRIX, casadi.SX(2, 1), elastic).elastic is elastic
