"""The local model of a problem: its numbers at the clamped start, the neighbourhood, free joints, shared symbols."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

from jtik._step.local_model import NEIGHBOURHOOD, linearized
from jtik.qp import QPRecorder
from jtik_formulations import JointCentering

from ..conftest import planar, planar_jacobian, planar_points
from .conftest import constants, inputs_of, numbers, problem_of

Q = np.array([0.4, -0.3, 0.8])
TARGET = np.array([1.0, 1.5])


def at(robot, q=Q, target=TARGET, *, criteria=None, neighbourhood=0.0, qps=None, **state):
    problem = problem_of(robot, criteria=criteria)
    inputs = constants(inputs_of(problem, target))
    return linearized(problem, casadi.SX(q), inputs, {"neighbourhood": casadi.SX(neighbourhood), **state}, qps)


def test_task_and_criterion_at_q():
    model = at(planar(3), criteria=JointCentering(2.0)).model
    r = planar_points(Q)[-1] - TARGET
    assert numbers(model.here.residual) == pytest.approx(r)
    assert numbers(model.here.V) == pytest.approx(r @ r / 2)
    assert numbers(model.J) == pytest.approx(planar_jacobian(Q))
    assert numbers(model.here.H) == pytest.approx(JointCentering(2.0)(Q, planar(3)))
    assert numbers(model.gradient) == pytest.approx(JointCentering(2.0).gradient(Q, planar(3)))
    assert model.has_criterion
    assert at(planar(3)).active_set is None


class TestNeighbourhood:
    radius = NEIGHBOURHOOD * np.linalg.norm(planar_jacobian(Q))

    def test_without_a_criterion_there_is_none(self):
        model = at(planar(3)).model
        assert (model.neighbourhood, model.near_target) == (0, 0)

    def test_its_first_radius_is_in_proportion_to_the_jacobian(self):
        assert numbers(at(planar(3), criteria=JointCentering()).model.neighbourhood) == pytest.approx(self.radius)

    def test_a_known_radius_stays(self):
        assert numbers(at(planar(3), criteria=JointCentering(), neighbourhood=0.3).model.neighbourhood) == 0.3

    @pytest.mark.parametrize(("share", "near"), [(0.99, True), (1.01, False)])
    def test_the_error_decides_whether_q_is_inside(self, share, near):
        target = planar_points(Q)[-1] + np.array([share * self.radius, 0])
        model = at(planar(3), target=target, criteria=JointCentering()).model
        assert bool(numbers(model.near_target)) is near


class TestLimits:
    def test_the_start_is_clamped(self):
        model = at(planar(3, lower=-0.5, upper=0.5)).model
        clamped = np.clip(Q, -0.5, 0.5)
        assert numbers(model.here.q).tolist() == clamped.tolist()
        assert numbers(model.here.residual) == pytest.approx(planar_points(clamped)[-1] - TARGET)
        assert numbers(model.J) == pytest.approx(planar_jacobian(clamped))

    def test_a_joint_at_its_limit_that_the_task_pushes_outward_is_not_free(self):
        robot = planar(3, lower=-0.5, upper=0.5)
        clamped = np.clip(Q, -0.5, 0.5)
        J, r = planar_jacobian(clamped), planar_points(clamped)[-1] - TARGET
        outward = (clamped == 0.5) & (-(J.T @ r) > 0)
        assert outward.tolist() == [False, False, True]
        model = at(robot, criteria=JointCentering()).model
        assert numbers(model.J_free) == pytest.approx(J * ~outward)
        assert numbers(model.gradient_free) == pytest.approx(numbers(model.gradient) * ~outward)
        assert numbers(model.J) == pytest.approx(J)


def test_beside_quadratic_programs_the_strategy_sees_symbols():
    found = at(planar(3), criteria=JointCentering(), qps=QPRecorder(1e-7))
    assert len(found.parts) == len(found.at) == 6
    assert all(part.is_constant() for part in found.parts)
    assert all(symbol.is_valid_input() for symbol in found.at)
    assert [symbol.shape for symbol in found.at] == [part.shape for part in found.parts]
    assert found.model.J is found.at[2]
    without = at(planar(3), criteria=JointCentering())
    assert without.at is without.parts
    no_criterion = at(planar(3), qps=QPRecorder(1e-7))
    assert len(no_criterion.parts) == len(no_criterion.at) == 4
    assert numbers(no_criterion.model.gradient).tolist() == [0, 0, 0]
