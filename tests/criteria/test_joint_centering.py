"""JointCentering: H = 1/2 (q - preferred)' K (q - preferred)."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik_formulations import JointCentering

from ..conftest import DIFFERENCES, EXACT, ball_arm, dh_arm, differences, look, planar


def solver(robot, criterion, kind="position"):
    return jtik.InverseKinematics(robot, jtik.FrameTask("tip", kind), criteria=criterion, limits=False)


def at(ik, q):
    return look(ik, q, ik.robot.pose(q))


def test_default_is_half_the_squared_angles(rng):
    robot = planar(6)
    ik = solver(robot, JointCentering())
    for _ in range(10):
        q = robot.random_configuration(rng)
        found = at(ik, q)
        assert found.cost == pytest.approx(q @ q / 2, rel=EXACT)
        assert found.gradient == pytest.approx(q, abs=EXACT)
        assert found.criteria == {"joint_centering": pytest.approx(q @ q / 2)}


@pytest.mark.parametrize("stiffness", [0.7, [1.0, 0.0, 2.0, 3.0, 0.5, 4.0]])
def test_stiffness_and_preferred_angles(stiffness, rng):
    robot = dh_arm(6, 1)
    preferred = rng.uniform(-1, 1, 6)
    ik = solver(robot, JointCentering(stiffness, preferred))
    k = np.broadcast_to(stiffness, 6)
    for _ in range(10):
        q = robot.random_configuration(rng)
        found = at(ik, q)
        assert found.cost == pytest.approx(k @ (q - preferred) ** 2 / 2, rel=EXACT)
        assert found.gradient == pytest.approx(k * (q - preferred), abs=EXACT)


def test_a_zero_stiffness_has_no_pull_not_even_a_nan():
    robot = planar(3)
    found = at(solver(robot, JointCentering([0.0, 0.0, 0.0])), [0.3, 0.0, -0.2])
    assert found.cost == 0
    assert found.gradient.tolist() == [0, 0, 0]


def test_the_middle_of_lopsided_limits_is_not_preferred_but_the_nearest_to_zero():
    robot = jtik.Robot.planar(2, lower=[0.5, -1.0], upper=[1.0, 1.0])
    assert at(solver(robot, JointCentering()), [0.5, 0.0]).cost == 0


def test_ball_joints_have_no_spring_the_others_do(rng):
    robot = ball_arm()
    ik = solver(robot, JointCentering(2.0))
    q = robot.random_configuration(rng)
    found = at(ik, q)
    scalars = q[robot.scalar_q]
    assert found.cost == pytest.approx(scalars @ scalars, rel=EXACT)
    numeric = differences(lambda p: at(ik, p).cost, robot, q)[0]
    assert found.gradient == pytest.approx(numeric, abs=DIFFERENCES)


def test_live_parameters_act_as_if_built_with_them(rng):
    robot = planar(5)
    preferred, stiffness = rng.uniform(-1, 1, 5), rng.uniform(0.1, 2, 5)
    changed, built = solver(robot, JointCentering()), solver(robot, JointCentering(stiffness, preferred))
    changed.parameters["joint_centering.preferred"] = preferred
    changed.parameters["joint_centering.stiffness"] = stiffness
    q0 = rng.uniform(-1, 1, 5)
    target = robot.position(rng.uniform(-1, 1, 5))
    assert changed.solve(target, q0=q0).q.tolist() == built.solve(target, q0=q0).q.tolist()


@pytest.mark.parametrize("stiffness", [-1.0, [1.0, -0.1], np.nan])
def test_a_negative_stiffness_is_refused(stiffness):
    with pytest.raises(jtik.ArgumentError, match="stiffness"):
        JointCentering(stiffness)


def test_sizes_that_do_not_fit_the_robot_are_refused():
    with pytest.raises(jtik.ArgumentError, match=r"preferred.*\(3,\)"):
        solver(planar(3), JointCentering(preferred=[0.0, 0.0]))
    with pytest.raises(jtik.ArgumentError, match=r"stiffness.*\(3,\)"):
        solver(planar(3), JointCentering([1.0, 2.0]))


def test_what_comes_in_is_copied():
    preferred = np.zeros(3)
    criterion = JointCentering(preferred=preferred)
    preferred[:] = 7.0
    assert at(solver(planar(3), criterion), [0.0, 0.0, 0.0]).cost == 0
