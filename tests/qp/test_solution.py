"""The check of a QP's solution: violation, stationarity, NaN."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

from jtik.qp import QPRecorder, QuadraticProgram, Rows

DATA = {
    "P": casadi.SX.eye(3),
    "q": casadi.SX([1.0, -2.0, 0.5]),
    "lower": casadi.SX([-1.0] * 3),
    "upper": casadi.SX([1.0] * 3),
    "rows": [Rows.equal("sum", casadi.SX.ones(1, 3), casadi.SX([0.5]))],
}


def test_violation_and_stationarity_and_nan():
    solution = QPRecorder(accuracy=1e-6).solve(QuadraticProgram(**DATA))
    check = casadi.Function(
        "check",
        [solution.x, solution.row_multipliers, solution.box_multipliers],
        [solution.violation, solution.stationarity, solution.solved(1e-6)],
    )
    # x = -q - y where the box is open: y from the sum, -1 + 2 - 0.5 - 3 y = 0.5 with the second at its bound
    x, y, z = np.array([-0.5, 1.0, 0.0]), np.array([-0.5]), np.array([0.0, 1.5, 0.0])
    assert [float(v) for v in check(x, y, z)] == pytest.approx([0, 0, 1], abs=1e-15)
    assert float(check([-0.4, 1.0, 0.0], y, z)[0]) == pytest.approx(0.1)
    assert float(check([-0.5, 1.2, -0.2], y, z)[0]) == pytest.approx(0.2)
    assert float(check(x, y + 1, z)[2]) == 0
    assert float(check([np.nan] * 3, y, z)[2]) == 0
