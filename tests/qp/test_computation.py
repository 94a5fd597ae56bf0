"""Python in the middle of a step: its answer is used, none is a status, and it stands beside programs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

import jtik
from jtik.qp import Conic, Foreign, QuadraticProgram
from jtik.strategy import Strategy, Update
from jtik.symbolic import zeros

from ..conftest import planar


@dataclass(frozen=True)
class Outside(Strategy):
    """dq = -J+ r by NumPy, perhaps through a program that moves the same way."""

    inverse: Any
    program: bool = False

    def uses_qp(self, has_criterion):
        return True

    def update(self, model, state):
        n = model.robot.n
        (dq,) = model.compute("inverse", self.inverse, [model.full_J, model.here.residual], [(n, 1)])
        if self.program:
            low, high = model.box
            dq = model.solve(QuadraticProgram(P=np.eye(n) + zeros(n, n), q=-dq, lower=low, upper=high, name="same")).x
        point = model.moved(-dq)
        return Update(point=point, accepted=1, state={}, term=-dq, wanted=-dq, null_term=zeros(n))


def pinv(arguments):
    columns, r = arguments
    return [-np.linalg.pinv(columns.reshape(-1, len(r)).T) @ r]


@pytest.mark.parametrize("program", [False, True])
@pytest.mark.parametrize("backend", [Conic(), Foreign("daqp")], ids=repr)
def test_its_answer_is_the_step(program, backend):
    robot = planar(4)
    ik = jtik.InverseKinematics(robot, jtik.FrameTask(), strategy=Outside(pinv, program), solver=backend)
    q, target = np.array([0.3, 0.4, 0.5, 0.6]), np.array([2.0, 2.0])
    expected = -np.linalg.pinv(robot.jacobian(q)[:2]) @ (robot.position(q) - target)
    assert ik.step(q, target).q - q == pytest.approx(expected, abs=1e-9)
    assert ik.solve(target, q0=q).converged


def test_matrices_come_and_go_columns_first():
    seen = []

    def look(arguments):
        columns, r = arguments
        seen.append(columns.reshape(-1, len(r)).T.copy())
        return pinv(arguments)

    robot, q = planar(3), np.array([0.3, 0.4, 0.5])
    jtik.InverseKinematics(robot, jtik.FrameTask(), strategy=Outside(look)).step(q, [1.0, 1.0])
    assert seen[0] == pytest.approx(robot.jacobian(q)[:2])


@pytest.mark.parametrize("answer", [lambda _: None, lambda _: [np.full(3, np.nan)]])
def test_no_answer_is_a_status(answer):
    ik = jtik.InverseKinematics(planar(3), jtik.FrameTask(), strategy=Outside(answer))
    q = np.array([0.3, 0.4, 0.5])
    solution = ik.solve([1.0, 1.0], q0=q)
    assert solution.status is jtik.Status.UNSOLVED
    assert solution.q == pytest.approx(q, abs=0)


def test_programs_beside_it_can_be_built_and_it_is_none():
    ik = jtik.InverseKinematics(planar(3), jtik.FrameTask(), strategy=Outside(pinv, True))
    problem = ik.build(np.array([0.3, 0.4, 0.5]), [1.0, 1.0])
    assert pytest.approx(np.eye(3)) == problem.P
    with pytest.raises(jtik.UnknownNameError, match="inverse"):
        ik.build(np.zeros(3), [1.0, 1.0], qp="inverse")
    alone = jtik.InverseKinematics(planar(3), jtik.FrameTask(), strategy=Outside(pinv))
    with pytest.raises(jtik.UnknownNameError, match="program"):
        alone.build(np.zeros(3), [1.0, 1.0])
