"""The convexity test: numeric matrices are refused, symbolic ones tested when evaluated."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

import jtik
from jtik.qp import QuadraticProgram
from jtik.qp.convexity import is_convex, smallest_eigenvalue
from jtik.symbolic import function, symbol, zeros


class TestNonConvexQP:
    @pytest.mark.parametrize("P", [-np.eye(4), np.diag([1.0, 1, 1, -1e-3]), np.ones((4, 4)) - np.eye(4)])
    def test_a_numeric_matrix_is_refused(self, P):
        box = np.full((4, 1), np.inf)
        with pytest.raises(
            jtik.ArgumentError, match=r"mine\.P: given .*not convex: its smallest eigenvalue is -.*semidef"
        ):
            QuadraticProgram(P=casadi.SX(P), q=zeros(4), lower=-box, upper=box, name="mine")

    def test_the_convexity_test_of_expressions(self, rng):
        P = symbol("P", 5, 5)
        convexity = function("convexity", [P], [is_convex(P)])
        for _ in range(200):
            M = rng.standard_normal((5, rng.integers(1, 6)))
            basis = np.linalg.qr(rng.standard_normal((5, 5)))[0]
            assert convexity(M @ M.T) == 1  # of any rank
            eigenvalues = np.append(-(10.0 ** rng.uniform(-3, 0)), rng.uniform(0, 1, 4))
            assert convexity(basis @ np.diag(eigenvalues) @ basis.T) == 0
        assert convexity(np.zeros((5, 5))) == 1
        assert convexity(np.eye(5)[::-1]) == 0
        assert convexity(np.full((5, 5), np.nan)) == 0


def test_the_smallest_eigenvalue_is_relative_to_the_largest_entry():
    assert smallest_eigenvalue(casadi.SX(np.diag([4.0, -1.0]))) == pytest.approx(-0.25)
    assert smallest_eigenvalue(symbol("P", 2, 2)) is None
    assert smallest_eigenvalue(casadi.SX(np.diag([1.0, np.nan]))) is None
    assert smallest_eigenvalue(casadi.SX(2, 2)) is None
