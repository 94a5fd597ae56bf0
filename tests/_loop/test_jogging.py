"""Jogging along the self-motion: against closed forms, the null space by SVD, and forward kinematics."""

from __future__ import annotations

import copy
import itertools
import math

import numpy as np
import pytest

import jtik
from jtik.problems.target_of import target_of
from jtik_formulations import JointCentering, ObstacleAvoidance

from ..conftest import ball_arm, floating_arm, planar, planar_jacobian, planar_points, shared_solver

PANDA = jtik.Robot.builtin("panda")
HOME = np.array(PANDA.keyframes["home"])
DT = 0.02

STILL = 1e-12
"""Motion of the end effector over thousands of calls [m] or [rad]: their rounding."""


def solver(robot, kind="pose", **options):
    return shared_solver(robot, jtik.FrameTask(robot.tip, kind), **options)


def jogged(ik, q, rate, *, count=5000, **options):
    """All configurations, and the last result, of calls until the self-motion ends."""
    rows, last = [np.asarray(q, dtype=float)], None
    for _ in range(count):
        last = ik.jog(rows[-1], rate, dt=DT, **options)
        rows.append(last.q)
        if last.ended:
            break
    return np.array(rows), last


class TestOneStep:
    @pytest.mark.quick(1, slow=8)
    @pytest.mark.parametrize("strategy", ["hybrid", *sorted(set(jtik.strategies) - {"hybrid"})])
    def test_it_is_along_the_null_space_and_as_fast_as_asked(self, strategy):
        ik = solver(PANDA, strategy=strategy)
        null = np.linalg.svd(PANDA.jacobian(HOME))[2][6]
        for rate in (0.5, -0.2):
            step = ik.jog(HOME, rate, dt=DT)
            dq = step.q - HOME
            assert np.linalg.norm(dq) == pytest.approx(abs(rate) * DT, rel=1e-3)
            assert abs(dq @ null) == pytest.approx(np.linalg.norm(dq), rel=1e-3)
            assert (dq @ (null * null[0]) > 0) == (rate > 0)  # a positive rate moves the joint with the largest part up
            assert step.rate == pytest.approx(rate)
            assert not step.ended
            assert step.reason == "moves along the self-motion"
            assert PANDA.pose(step.q) == pytest.approx(PANDA.pose(HOME), abs=STILL)

    def test_a_rate_of_zero_rests(self):
        step = solver(PANDA).jog(HOME, 0.0)
        assert step.q.tolist() == HOME.tolist()
        assert not step.ended
        assert "at rest" in step.reason

    def test_a_step_has_a_longest_length(self):
        step = solver(planar(4), "position").jog([0.4, 0.6, -0.3, 0.5], 100.0)
        assert step.rate * DT == pytest.approx(0.1)
        assert "0.1 rad" in step.reason

    def test_the_target_of_the_last_solve_does_not_matter(self, rng):
        ik, fresh = solver(PANDA), solver(PANDA)
        ik.solve(PANDA.pose(PANDA.random_configuration(rng)), max_iterations=3)
        assert ik.jog(HOME, 0.5).q.tolist() == fresh.jog(HOME, 0.5).q.tolist()

    @pytest.mark.quick(1)
    @pytest.mark.parametrize("robot", [ball_arm(), floating_arm()], ids=str)
    def test_quaternions_and_prismatic_joints(self, robot, rng):
        ik = solver(robot)
        q = robot.integrate(robot.neutral, rng.uniform(-0.3, 0.3, robot.n))
        q = np.clip(q, robot.lower, robot.upper)
        rows, _ = jogged(ik, q, 0.5, count=100)
        lengths = [np.linalg.norm(robot.difference(a, b)) for a, b in itertools.pairwise(rows)]
        assert np.median(lengths) == pytest.approx(0.5 * DT, rel=1e-3)
        assert robot.pose(rows[-1]) == pytest.approx(robot.pose(q), abs=STILL)

    @pytest.mark.quick(2)
    @pytest.mark.parametrize(
        "task",
        [
            jtik.AxisTask("tip", (0, 0, 1)),
            jtik.LookAtTask("tip", (0, 0, 1)),
            jtik.FrameTask(PANDA.tip, "orientation", axes=["rx", "ry"]),
            jtik.FrameTask(PANDA.tip, "pose", error="logarithm"),
            jtik.RelativeFrameTask(PANDA.tip, PANDA.frame_names[2], "position"),
        ],
        ids=repr,
    )
    def test_every_task_is_held(self, task):
        robot = PANDA
        ik = shared_solver(robot, task, joints="all")
        target = target_of(task, robot, HOME)
        ik.solve(target, q0=HOME)  # a point to look at is that of the last target
        rows, last = jogged(ik, HOME, 0.4, count=60, direction=np.arange(1.0, 8.0))
        assert last.position_error < STILL
        assert last.orientation_error < STILL
        assert np.linalg.norm(rows[-1] - HOME) > 0.1
        assert np.linalg.norm(ik.solve(target, q0=rows[-1], max_iterations=0).error) < 1e-10


class TestAFullSelfMotion:
    @pytest.mark.slow
    def test_the_elbow_of_a_panda_goes_from_limit_to_limit_and_back(self):
        """The elbow's angle about the line from shoulder to wrist changes one way only; the flange stands still."""
        ik = solver(PANDA)
        up, end = jogged(ik, HOME, 0.5)
        assert end.ended
        assert "at the limit of 'panda_joint2'" in end.reason
        assert up[-1][1] == pytest.approx(PANDA.lower[1], abs=1e-9)
        down, end = jogged(ik, up[-1], -0.5)
        assert end.ended
        assert down[-1][1] == pytest.approx(PANDA.lower[1], abs=1e-9)
        again, _ = jogged(ik, down[-1], 0.5)
        assert again[-1] == pytest.approx(up[-1], abs=1e-6)
        for rows in (up, down, again):
            assert max(np.abs(PANDA.pose(q) - PANDA.pose(HOME)).max() for q in rows) < STILL
            assert (rows >= PANDA.lower - 1e-12).all()
            assert (rows <= PANDA.upper + 1e-12).all()
        angles = np.unwrap([swivel(PANDA, q, "panda_link4") for q in down])
        assert (np.diff(angles)[:-1] < 0).all() or (np.diff(angles)[:-1] > 0).all()
        assert abs(angles[-1] - angles[0]) > 3.0

    def test_out_and_back_returns(self):
        """The curve is the same; along it the step is right to second order, so that both ways cancel to third."""
        ik = solver(PANDA)
        out, _ = jogged(ik, HOME, 0.5, count=200)
        back, _ = jogged(ik, out[-1], -0.5, count=200)
        assert np.linalg.norm(out[-1] - HOME) > 1.0
        assert back[-1] == pytest.approx(HOME, abs=1e-4)

    @pytest.mark.slow
    def test_three_links_go_all_the_way_round(self):
        """A four-bar linkage whose crank turns fully: the self-motion is closed, and is met again at its start."""
        robot = jtik.Robot.planar([0.4, 1.0, 1.0])
        ik, q0 = solver(robot, "position"), np.array([0.3, 1.4, -2.1])
        tip = robot.position(q0)
        rows, _ = jogged(ik, q0, 1.0, count=2000)
        assert max(np.linalg.norm(robot.position(q) - tip) for q in rows) < STILL
        distances = np.linalg.norm(np.sin((rows - q0) / 2), axis=1)
        turn = np.flatnonzero((distances[100:-1] < distances[99:-2]) & (distances[100:-1] < distances[101:]))
        assert distances[100 + turn].min() < 0.5 * DT
        assert abs(rows[:, 0] - q0[0]).max() > 2 * math.pi


def swivel(robot, q, elbow):
    """The angle of the elbow about the line from the shoulder to the wrist."""
    shoulder, wrist = robot.position(q, "panda_link2"), robot.position(q, "panda_link6")
    axis = (wrist - shoulder) / np.linalg.norm(wrist - shoulder)
    first = np.cross(axis, [0.0, 1.0, 0.0])
    first /= np.linalg.norm(first)
    away = robot.position(q, elbow) - shoulder
    return math.atan2(away @ np.cross(axis, first), away @ first)


class TestTheEnd:
    def test_a_joint_at_the_end_of_its_range_comes_back(self):
        """Joint 1 of three links is furthest where the other two are in line."""
        ik, q0 = solver(planar(3), "position"), np.array([0.4, 0.6, 0.5])
        tip = planar_points(q0)[-1]
        reach, distance = 2.0, np.linalg.norm(tip)
        furthest = math.atan2(tip[1], tip[0]) + math.acos((1 + distance**2 - reach**2) / (2 * distance))
        up, end = jogged(ik, q0, 0.5, direction="joint1")
        assert end.ended
        assert "'joint1' is at the end of its range" in end.reason
        assert up[-1][0] == pytest.approx(furthest, abs=1e-6)
        assert ik.jog(up[-1], 0.5, direction="joint1").ended
        back, end = jogged(ik, up[-1], -0.5, direction="joint1", count=300)
        assert not end.ended
        assert back[-1][0] < furthest - 0.3
        assert np.sign(back[-1][2]) == np.sign(q0[2])  # the way it came
        ik.reset()  # without a memory there are two ways back
        fresh, end = jogged(ik, up[-1], -0.5, direction="joint1", count=300)
        assert fresh[-1][0] < furthest - 0.3

    def test_the_descent_of_a_criterion_ends_at_its_minimum_and_rises_from_there(self):
        criterion = JointCentering()
        ik, q0 = solver(planar(5), "position", criteria=criterion), np.array([0.9, 0.7, -0.5, 0.4, 0.8])
        best = ik.solve(planar_points(q0)[-1], q0=q0)
        for direction in ("descent", "joint_centering"):
            rows, end = jogged(ik, q0, 0.5, direction=direction)
            assert end.ended
            assert "cannot fall further" in end.reason
            assert rows[-1] == pytest.approx(best.q, abs=1e-3)
            H = np.sum(rows**2, axis=1) / 2
            assert (np.diff(H) < 1e-12).all()
            up, end = jogged(ik, rows[-1], -0.5, direction=direction, count=50)
            assert not end.ended
            assert np.sum(up[-1] ** 2) > np.sum(rows[-1] ** 2) + 1e-3

    def test_an_arm_at_full_reach_has_no_self_motion(self):
        """There J has a null space, and no curve in its direction leaves the end effector where it is."""
        step = solver(planar(3), "position").jog(np.zeros(3), 0.5)
        assert step.ended
        assert "singular pose" in step.reason
        assert step.q.tolist() == [0, 0, 0]

    def test_six_joints_and_a_pose_have_none(self):
        robot = jtik.Robot.builtin("ur5e")
        step = solver(robot).jog(robot.keyframes["home"], 0.5)
        assert step.ended
        assert "0 dimensions" in step.reason

    def test_a_clearance_ends_it(self):
        field = ObstacleAvoidance(jtik.Circle((1.7, 1.1), 0.3), bodies="links")
        clearance = jtik.Clearance(field, safe=0.05)
        robot, q0 = planar(4), np.array([0.6, -0.9, 0.5, 0.4])
        ends = {}
        for clearances in (None, clearance):
            ik = solver(robot, "position", strategy="hybrid+qp", clearances=clearances)
            rows, ends[clearances is None] = jogged(ik, q0, 0.5, count=150, direction="joint1")
            if clearances:
                assert ends[False].ended
                assert ends[False].reason == "ended: a clearance"
                gap = min(np.linalg.norm(link_point - (1.7, 1.1)) for q in rows for link_point in along_links(q)) - 0.3
                assert 0.05 - 1e-9 <= gap < 0.1
                back, _ = jogged(ik, rows[-1], -0.5, count=20, direction="joint1")
                assert len(back) == 21


def along_links(q):
    points = np.vstack([[0.0, 0.0], planar_points(q)])
    return [a + s * (b - a) for a, b in itertools.pairwise(points) for s in np.linspace(0, 1, 21)]


class TestLimits:
    def test_velocity_limits_are_kept(self):
        limits = jtik.Limits(velocity=0.1)
        rows, _ = jogged(solver(PANDA, limits=limits), HOME, 1.0, count=100)
        speeds = np.abs(np.diff(rows, axis=0)) / DT
        assert speeds.max() == pytest.approx(0.1, abs=1e-9)
        assert PANDA.pose(rows[-1]) == pytest.approx(PANDA.pose(HOME), abs=STILL)

    @pytest.mark.slow
    def test_acceleration_limits_are_kept_to_the_stop_at_a_limit_and_after_the_slider_is_let_go(self):
        ik = solver(PANDA, limits=jtik.Limits(acceleration=2.0))
        for release in (None, 60):
            ik.reset()
            rows = [HOME]
            for k in range(600):
                rows.append(ik.jog(rows[-1], 0.0 if release and k >= release else 1.0, dt=DT).q)
            speeds = np.diff(rows, axis=0, prepend=[HOME]) / DT
            assert np.abs(np.diff(speeds, axis=0)).max() <= 2.0 * DT + 1e-9
            assert np.abs(speeds[-1]).max() < 1e-6
            assert PANDA.pose(rows[-1]) == pytest.approx(PANDA.pose(HOME), abs=STILL)
            assert (rows[-1][1] < PANDA.lower[1] + 1e-6) == (release is None)

    def test_a_step_with_dt_and_a_jog_share_the_last_motion(self):
        ik = solver(PANDA, limits=jtik.Limits(acceleration=2.0))
        rows = [HOME]
        for _ in range(30):
            rows.append(ik.jog(rows[-1], 1.0, dt=DT).q)
        for _ in range(30):
            rows.append(ik.step(rows[-1], PANDA.pose(HOME), dt=DT).q)
        speeds = np.diff(rows, axis=0) / DT
        assert np.abs(np.diff(speeds, axis=0)).max() <= 2.0 * DT + 1e-9

    def test_outside_its_limits_it_comes_back_first(self):
        q = HOME.copy()
        q[3] = PANDA.upper[3] + 0.05
        rows, _ = jogged(solver(PANDA), q, 0.5, count=40)
        assert (rows[-1] <= PANDA.upper + 1e-12).all()

    def test_with_more_freedom_it_goes_on_along_a_limit(self):
        robot = jtik.Robot.planar(6, lower=-1.5, upper=1.5)
        rows, end = jogged(solver(robot, "position"), [0.4, 0.6, 0.5, -0.3, 0.2, -0.8], 0.5, count=400, direction=2)
        at = np.flatnonzero((np.abs(rows) >= 1.5 - 1e-9).any(axis=1))
        assert at.size > 10
        assert not end.ended
        assert np.linalg.norm(rows[-1] - rows[at[0]]) > 0.1

    def test_locked_joints_stay(self):
        robot = jtik.Robot.planar(5, lower=[-2, -2, 0.3, -2, -2], upper=[2, 2, 0.3, 2, 2])
        q0 = np.array([0.4, 0.6, 0.3, -0.5, 0.2])
        for direction in (0, 1, np.ones(5)):
            rows, _ = jogged(solver(robot, "position"), q0, 0.5, count=50, direction=direction)
            assert np.ptp(rows[:, 2]) == 0
            assert np.linalg.norm(rows[-1] - q0) > 0.05


class TestDirections:
    ROBOT, Q = planar(6), np.array([0.4, 0.6, 0.5, -0.3, 0.2, -0.8])

    def projector(self, q):
        J = planar_jacobian(q)
        return np.eye(len(q)) - np.linalg.pinv(J) @ J

    @pytest.mark.parametrize("direction", ["joint3", np.array([1.0, 0, 0, -2.0, 0, 0.5])])
    def test_a_joint_or_a_vector_is_projected(self, direction):
        ik = solver(self.ROBOT, "position")
        wish = np.eye(6)[2] if isinstance(direction, str) else direction
        expected = self.projector(self.Q) @ wish
        dq = ik.jog(self.Q, 0.05, direction=direction).q - self.Q
        assert dq / np.linalg.norm(dq) == pytest.approx(expected / np.linalg.norm(expected), abs=1e-3)

    def test_the_basis_is_orthonormal_and_spans_the_null_space(self):
        ik = solver(self.ROBOT, "position")
        steps = np.array([ik.jog(self.Q, 5e-4, direction=k).q - self.Q for k in range(4)]) / 1e-5
        assert steps @ steps.T == pytest.approx(np.eye(4), abs=1e-4)
        assert steps.T @ steps == pytest.approx(self.projector(self.Q), abs=1e-4)
        assert ik.jog(self.Q, 0.5, direction=4).ended

    def test_the_basis_does_not_jump_and_is_deterministic(self):
        """From call to call it turns by as little as the null space does, past many changes of the largest entry."""
        runs = []
        for _ in range(2):
            ik = solver(self.ROBOT, "position")
            runs.append(jogged(ik, self.Q, 0.5, count=600, direction=1)[0])
        assert runs[0].tolist() == runs[1].tolist()
        unit = np.diff(runs[0], axis=0) / (0.5 * DT)
        turns = np.linalg.norm(np.diff(unit, axis=0), axis=1)
        largest = np.argmax(np.abs(unit), axis=1)
        assert (np.diff(largest) != 0).sum() >= 2
        assert turns.max() < 0.1

    def test_copies_begin_anew_and_reset_does(self):
        ik = solver(self.ROBOT, "position")
        first = ik.jog(self.Q, 0.5, direction=1).q
        jogged(ik, self.Q, 0.5, count=300, direction=1)
        assert copy.copy(ik).jog(self.Q, 0.5, direction=1).q.tolist() == first.tolist()
        ik.reset()
        assert ik.jog(self.Q, 0.5, direction=1).q.tolist() == first.tolist()


@pytest.mark.parametrize(
    ("options", "argument"),
    [
        ({"rate": math.nan}, "rate"),
        ({"rate": "fast"}, "rate"),
        ({"rate": True}, "rate"),
        ({"dt": 0.0}, "dt"),
        ({"dt": None}, "dt"),
        ({"direction": "nobody"}, "direction"),
        ({"direction": "descent"}, "direction"),
        ({"direction": 7}, "direction"),
        ({"direction": -1}, "direction"),
        ({"direction": True}, "direction"),
        ({"direction": np.zeros(7)}, "direction"),
        ({"direction": np.ones(6)}, "direction"),
        ({"direction": np.full(7, np.nan)}, "direction"),
        ({"q": np.zeros(6)}, "q"),
        ({"q": np.full(7, np.inf)}, "q"),
    ],
)
def test_wrong_input(options, argument):
    with pytest.raises(jtik.ArgumentError) as caught:
        solver(PANDA).jog(**({"q": HOME, "rate": 0.5} | options))
    assert caught.value.argument == argument
