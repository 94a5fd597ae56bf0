"""Python computations inside a step: results are used, missing ones are a status, and QPs may stand beside them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

import jtik
from jtik.qp import Conic, QPSolversBackend, QuadraticProgram
from jtik.strategy import Strategy, Update
from jtik.symbolic import zeros

from ..conftest import planar


@dataclass(frozen=True)
class NumpyNewton(Strategy):
    """dq = -J+ r by NumPy, optionally followed by a QP whose solution is the same dq."""

    inverse: Any
    with_qp: bool = False

    def uses_qp(self, has_criterion):
        return True

    def update(self, model, state):
        n = model.robot.n
        (dq,) = model.compute("inverse", self.inverse, [model.J, model.here.residual], [(n, 1)])
        if self.with_qp:
            low, high = model.box
            dq = model.solve(QuadraticProgram(P=np.eye(n) + zeros(n, n), q=-dq, lower=low, upper=high, name="same")).x
        return Update(dq)


def pinv(arguments):
    columns, r = arguments
    return [-np.linalg.pinv(columns.reshape(-1, len(r)).T) @ r]


@pytest.mark.parametrize("with_qp", [False, True])
@pytest.mark.parametrize("backend", [Conic(), QPSolversBackend("daqp")], ids=repr)
def test_the_result_is_the_step(with_qp, backend):
    robot = planar(4)
    ik = jtik.InverseKinematics(robot, jtik.FrameTask(), strategy=NumpyNewton(pinv, with_qp), solver=backend)
    q, target = np.array([0.3, 0.4, 0.5, 0.6]), np.array([2.0, 2.0])
    expected = -np.linalg.pinv(robot.jacobian(q)[:2]) @ (robot.position(q) - target)
    assert ik.step(q, target).q - q == pytest.approx(expected, abs=1e-9)
    assert ik.solve(target, q0=q).converged


def test_matrices_are_passed_in_column_major_order():
    seen = []

    def record(arguments):
        columns, r = arguments
        seen.append(columns.reshape(-1, len(r)).T.copy())
        return pinv(arguments)

    robot, q = planar(3), np.array([0.3, 0.4, 0.5])
    jtik.InverseKinematics(robot, jtik.FrameTask(), strategy=NumpyNewton(record)).step(q, [1.0, 1.0])
    assert seen[0] == pytest.approx(robot.jacobian(q)[:2])


@pytest.mark.parametrize("answer", [lambda _: None, lambda _: [np.full(3, np.nan)]])
def test_a_missing_result_is_a_status(answer):
    ik = jtik.InverseKinematics(planar(3), jtik.FrameTask(), strategy=NumpyNewton(answer))
    q = np.array([0.3, 0.4, 0.5])
    solution = ik.solve([1.0, 1.0], q0=q)
    assert solution.status is jtik.Status.UNSOLVED
    assert solution.q == pytest.approx(q, abs=0)


def test_build_returns_the_qp_and_not_the_computation():
    ik = jtik.InverseKinematics(planar(3), jtik.FrameTask(), strategy=NumpyNewton(pinv, True))
    problem = ik.build(np.array([0.3, 0.4, 0.5]), [1.0, 1.0])
    assert pytest.approx(np.eye(3)) == problem.P
    with pytest.raises(jtik.UnknownNameError, match="inverse"):
        ik.build(np.zeros(3), [1.0, 1.0], qp="inverse")
    alone = jtik.InverseKinematics(planar(3), jtik.FrameTask(), strategy=NumpyNewton(pinv))
    with pytest.raises(jtik.UnknownNameError, match="program"):
        alone.build(np.zeros(3), [1.0, 1.0])
