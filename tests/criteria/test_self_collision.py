"""SelfCollision: its value and gradient by hand, its distances against MuJoCo, its parameters."""

from __future__ import annotations

import functools
import pickle

import casadi
import numpy as np
import pytest

import jtik
from jtik.testing import check_criterion
from jtik_formulations import SelfCollision

from ..conftest import DIFFERENCES, EXACT, ball_arm, dh_arm, planar, shared_solver, slow
from .mujoco_bodies import Judge

ROUNDING = 1e-12


@functools.cache
def panda():
    return jtik.Robot.builtin("panda")


@functools.cache
def measured(robot, criterion):
    """(q, gains) -> the distances that a clearance measures, and their Jacobian."""
    q, gains = casadi.SX.sym("q", robot.nq), casadi.SX.sym("gains", len(criterion.pairs(robot)))
    rows = criterion.distances(robot.at(q), {"gains": gains})
    d = casadi.vertcat(*[row[0] for row in rows])
    return casadi.Function("distances", [q, gains], [d, casadi.jacobian(d, q)])


def distances(robot, criterion, q):
    return measured(robot, criterion)(q, np.ones(len(criterion.pairs(robot))))[0].full()[:, 0]


@pytest.mark.quick(1)
@pytest.mark.parametrize("name", ["panda", "ur5e", "iiwa14"])
def test_distances_are_those_of_mujocos_capsules(name, rng):
    robot, criterion = jtik.Robot.builtin(name), SelfCollision()
    judge = Judge(robot, robot.collision_pairs())
    for _ in range(20):
        q = robot.random_configuration(rng)
        assert distances(robot, criterion, q) == pytest.approx(judge.distances(q), abs=ROUNDING)


def test_distances_of_links_are_those_of_mujocos_capsules(rng):
    robot, criterion = dh_arm(6, 2), SelfCollision(radius=0.03)
    judge = Judge(robot, robot.collision_pairs(radius=0.03))
    for _ in range(20):
        q = robot.random_configuration(rng)
        assert distances(robot, criterion, q) == pytest.approx(judge.distances(q), abs=ROUNDING)


class TestValue:
    def test_a_folded_arm_by_hand(self):
        """The third link runs back 1 m above the first one."""
        robot, criterion = planar(3), SelfCollision(radius=0.1, influence=0.5, gain=2.0)
        q = [0.0, np.pi / 2, np.pi / 2]
        gap = 1.0 - 0.2
        assert criterion(q, robot) == 0
        near = SelfCollision(radius=0.1, influence=1.0, gain=2.0)
        assert near(q, robot) == pytest.approx(2.0 * (1 - gap) ** 3, rel=EXACT)

    def test_it_is_zero_with_zero_derivatives_where_all_pairs_are_far_apart(self):
        robot = planar(6)
        assert SelfCollision()(np.zeros(6), robot) == 0
        assert SelfCollision().gradient(np.zeros(6), robot).tolist() == [0] * 6

    def test_it_is_the_sum_over_the_pairs(self, rng):
        robot, criterion = panda(), SelfCollision(influence=0.3, gain=1.5)
        for _ in range(10):
            q = robot.random_configuration(rng)
            expected = 1.5 * (np.maximum(0, 1 - distances(robot, criterion, q) / 0.3) ** 3).sum()
            assert criterion(q, robot) == pytest.approx(expected, rel=1e-10)

    def test_its_gradient_opens_a_folded_arm(self):
        robot = planar(3)
        q = np.array([0.0, 1.9, 1.9])
        gradient = SelfCollision(influence=1.0).gradient(q, robot)
        assert abs(gradient[0]) < EXACT  # the first joint moves both links
        assert (gradient[1:] > 0).all()

    def test_where_links_of_a_planar_arm_cross_the_gradient_separates_them(self):
        robot, q = planar(3), np.array([0.0, 2.8, 2.8])
        criterion = SelfCollision(influence=0.3)
        gradient = criterion.gradient(q, robot)
        ahead = criterion(q - 1e-3 * gradient / np.linalg.norm(gradient), robot)
        assert np.linalg.norm(gradient) > 0.1
        assert ahead < criterion(q, robot)


class TestDerivatives:
    @pytest.mark.quick(1)
    @pytest.mark.parametrize("robot", [ball_arm, lambda: planar(8), *slow(panda, lambda: dh_arm(6, 3))])
    def test_the_gradient_is_that_of_differences(self, robot):
        check_criterion(SelfCollision(influence=0.3), robot(), samples=10)

    def test_the_hessian_is_that_of_differences(self, rng):
        robot, criterion = panda(), SelfCollision(influence=0.4)
        q = casadi.SX.sym("q", 7)
        H = criterion.value(robot.at(q), {"gain": 1.0, "influence": 0.4, "gains": casadi.DM.ones(60)})
        hessian, gradient = casadi.hessian(H, q)
        function = casadi.Function("derivatives", [q], [gradient, hessian])
        agreeing = 0
        for _ in range(20):
            at, step = robot.random_configuration(rng), 1e-6
            rows = [
                (function(at + step * unit)[0] - function(at - step * unit)[0]).full()[:, 0] / (2 * step)
                for unit in np.eye(7)
            ]
            found = function(at)[1].full()
            agreeing += np.abs(np.array(rows) - found).max() <= 1e-4 * max(1, np.abs(found).max())
        assert agreeing >= 18  # it jumps where a closest point reaches an end

    def test_the_jacobian_of_the_distances_is_that_of_differences(self, rng):
        """Their derivatives are those with the closest points fixed on the axes."""
        robot, criterion = panda(), SelfCollision()
        function, gains = measured(robot, criterion), np.ones(len(criterion.pairs(panda())))
        for _ in range(5):
            q, step = robot.random_configuration(rng), 1e-5
            J = function(q, gains)[1].full()
            for j, unit in enumerate(np.eye(7)):
                ahead, behind = (distances(robot, criterion, q + sign * step * unit) for sign in (1, -1))
                assert J[:, j] == pytest.approx((ahead - behind) / (2 * step), abs=100 * DIFFERENCES)

    def test_they_are_finite_where_axes_cross_or_are_parallel(self):
        for q in ([0.0, 0.0, 0.0], [0.0, np.pi, np.pi], [0.0, np.pi, 0.0], [0.0, 3.0, 3.0]):
            criterion = SelfCollision(influence=0.5, include=[("link1-link2", "link2-link3")])
            assert np.isfinite(criterion.gradient(q, planar(3))).all()
            assert np.isfinite(criterion(q, planar(3)))


class TestParameters:
    def test_they_are_live(self):
        robot = planar(4)
        ik = shared_solver(robot, jtik.FrameTask(), criteria=SelfCollision(influence=1.0))
        q = np.array([0.0, 1.8, 1.8, 0.4])
        at = robot.position(q)
        before = ik.solve(at, q0=q, max_iterations=0).cost
        ik.parameters["self_collision.gain"] = 3.0
        assert ik.solve(at, q0=q, max_iterations=0).cost == pytest.approx(3 * before, rel=EXACT)
        ik.parameters["self_collision.gains"] = [0.0, 0.0, 0.0]
        assert ik.solve(at, q0=q, max_iterations=0).cost == 0
        ik.parameters["self_collision.gains"] = [1.0, 0.0, 0.0]
        alone = SelfCollision(influence=1.0, exclude=["link4-tip"])(q, robot)
        assert ik.solve(at, q0=q, max_iterations=0).cost == pytest.approx(3 * alone, rel=EXACT)
        ik.parameters["self_collision.influence"] = 1e-9  # not divided by
        assert np.isfinite(ik.solve(at, q0=q).q).all()

    def test_a_pair_with_gain_zero_is_absent_from_a_clearance(self):
        robot, criterion = panda(), SelfCollision()
        gains = np.ones(len(criterion.pairs(robot)))
        gains[3] = 0
        found = measured(robot, criterion)(robot.home, gains)[0].full()[:, 0]
        assert (found > 1e6).tolist() == [i == 3 for i in range(len(gains))]

    def test_names_select_pairs(self):
        robot = panda()
        few = SelfCollision(exclude=["panda_hand", "panda_link7"])
        assert len(few.pairs(robot)) < len(SelfCollision().pairs(robot))
        more = SelfCollision(include=[("panda_link5[1]", "panda_link7")])
        assert "panda_link5[1] to panda_link7" in more.pair_names(robot)

    def test_it_lowers_h_and_keeps_the_task(self):
        """Links that are rolled up unroll as far as the target allows."""
        robot, q = planar(7), np.array([0.2, 1.2, 1.0, 0.9, 1.3, 0.8, 0.5])
        ik = shared_solver(robot, jtik.FrameTask(), criteria=SelfCollision(influence=0.6), strategy="hybrid")
        start = ik.solve(robot.position(q), q0=q, max_iterations=0)
        end = ik.solve(robot.position(q), q0=q, max_iterations=500)
        assert end.position_error < 1e-6
        assert start.cost > 1
        assert end.cost < 1e-6


class TestWrongInput:
    @pytest.mark.parametrize(
        ("options", "argument"),
        [
            ({"gain": -1}, "gain"),
            ({"influence": 0}, "influence"),
            ({"influence": np.inf}, "influence"),
            ({"radius": -0.1}, "radius"),
            ({"within": -0.1}, "within"),
            ({"bodies": "solids"}, "bodies"),
            ({"exclude": "panda_hand"}, "exclude"),
            ({"include": [("a", "b", "c")]}, "include"),
            ({"name": ""}, "name"),
        ],
    )
    def test_arguments_out_of_range(self, options, argument):
        with pytest.raises(jtik.ArgumentError) as caught:
            SelfCollision(**options)
        assert caught.value.argument == argument

    def test_a_robot_of_which_no_two_bodies_can_touch(self):
        with pytest.raises(
            jtik.ArgumentError, match="robot: given Robot.*of whose 2 bodies no two can touch; accepted"
        ):
            shared_solver(planar(2), jtik.FrameTask(), criteria=SelfCollision())

    def test_unknown_bodies(self):
        with pytest.raises(jtik.UnknownNameError, match="unknown body 'hand'"):
            jtik.InverseKinematics(panda(), jtik.FrameTask(), criteria=SelfCollision(exclude=["hand"]))


def test_it_can_be_pickled_and_printed():
    criterion = SelfCollision(exclude=["a", ("b", "c")], gain=2.0, radius=0.1)
    copy = pickle.loads(pickle.dumps(criterion))
    assert repr(copy) == "SelfCollision(exclude=['a', ('b', 'c')], gain=2.0, radius=0.1)"
    assert repr(SelfCollision()) == "SelfCollision()"
