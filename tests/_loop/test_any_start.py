"""Solves from any start to any target, with every strategy, on real arms: the status of each Solution is correct.

Each strategy meets one arm and one kind of pose, in turn: ``--full`` runs all of them.
"""

from __future__ import annotations

import functools
import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation as Turn

import jtik
from jtik import Status
from jtik_formulations import Damped

from ..conftest import families_first, slow, under_limits

UNCHECKED = Damped(backtracking=False)
"""A strategy that takes every step, wherever it leads."""

ALL_STRATEGIES = families_first([*sorted(jtik.strategies), UNCHECKED])
DESCENDING = ["damped", "hybrid"]
"""Strategies that promise the closest posture where the target is out of reach."""

pytestmark = pytest.mark.thinned(together=True, times=2)

TOLERANCE = 1e-6
"""The default one of a solve [m], [rad]."""


def called(strategy):
    return strategy if isinstance(strategy, str) else "unchecked"


@functools.cache
def arm(name):
    return jtik.Robot.builtin(name)


@functools.cache
def built(name, strategy, frame, kind, limits):
    return jtik.InverseKinematics(arm(name), jtik.FrameTask(frame, kind), strategy=strategy, limits=limits)


def solver(name, strategy, frame="tip", kind="pose", limits=True):
    return built(name, strategy, frame, kind, limits)


def starts(robot, rng):
    """Inside the limits, with some joints at them, and with some outside."""
    inside = robot.random_configuration(rng)
    ends = np.where(rng.random(robot.n) < 0.5, robot.lower, robot.upper)
    yield inside
    yield np.where(rng.random(robot.n) < 0.5, ends, inside)
    yield inside + rng.uniform(-3, 3, robot.n)


def targets(robot, rng):
    """Within reach of the robot, and out of it."""
    reachable = robot.pose(robot.random_configuration(rng))
    away = reachable.copy()
    away[:3, 3] *= 5.0
    return reachable, away


def excess(robot, q):
    """How far each joint is outside its limits [rad]."""
    return np.maximum(np.maximum(robot.lower - q, q - robot.upper), 0.0)


def assert_true(robot, solution, target):
    """The status says what the pose of the solution shows."""
    pose = robot.pose(solution.q)
    away = np.linalg.norm(pose[:3, 3] - target[:3, 3])
    turned = Turn.from_matrix(pose[:3, :3].T @ target[:3, :3]).magnitude()
    assert solution.position_error == pytest.approx(away, abs=1e-12)
    assert solution.orientation_error == pytest.approx(turned, abs=1e-7)  # near pi an angle is that exact
    reached = away <= TOLERANCE and turned <= TOLERANCE
    assert (solution.status is Status.CONVERGED) == solution.converged == reached
    assert solution.status is not Status.NOT_FINITE
    if solution.status is Status.LIMITS:
        assert solution.active_limits
    assert not excess(robot, solution.q).any()


@pytest.mark.parametrize("restarts", [3, *slow(0)])
@pytest.mark.parametrize("strategy", ALL_STRATEGIES, ids=called)
@pytest.mark.parametrize("name", ["panda", *slow("ur5e")])
def test_from_anywhere_to_anywhere_the_status_is_correct_and_limits_hold(name, strategy, restarts):
    robot, ik, rng = arm(name), solver(name, strategy), np.random.default_rng(7)
    for _ in range(2):
        for q0 in starts(robot, rng):
            for target in targets(robot, rng):
                solution = ik.solve(target, q0=q0, max_iterations=100, restarts=restarts, trace=True)
                assert_true(robot, solution, target)
                rows = excess(robot, under_limits(robot, np.vstack([q0, solution.trace.q])))
                assert (rows[1:] <= rows[:-1]).all()
                assert np.isfinite(solution.trace.q).all()


@pytest.mark.parametrize("strategy", ALL_STRATEGIES, ids=called)
@pytest.mark.parametrize("name", ["panda", *slow("ur5e")])
def test_steps_return_into_the_limits_and_stay(name, strategy):
    robot, ik, rng = arm(name), solver(name, strategy), np.random.default_rng(8)
    for q in starts(robot, rng):
        target = robot.pose(robot.random_configuration(rng))
        ik.reset()
        for _ in range(30):
            before, q = excess(robot, q), ik.step(q, target).q
            assert (excess(robot, q) <= before).all()
        assert not excess(robot, q).any()


QUARTER = math.pi / 2

SINGULAR = {
    "a straight Panda": ("panda", np.zeros(7), False),
    "a Panda within its limits": ("panda", np.array([0.3, 0.0, QUARTER, -1.5, 0.0, 0.7, 0.2]), True),
    "a UR wrist with two axes in line": ("ur5e", np.array([0.3, -1.2, 1.4, 0.5, 0.0, 0.2]), True),
    "a UR wrist turned over": ("ur5e", np.array([0.3, -1.2, 1.4, 0.5, math.pi, 0.2]), True),
    "a stretched UR": ("ur5e", np.array([0.4, -0.8, 0.0, 0.5, 1.0, 0.2]), True),
    "a UR with its wrist above its shoulder": ("ur5e", np.array([0.4, -QUARTER, 0.0, -QUARTER, 1.0, 0.2]), True),
}
QUICK_SINGULAR = ["a Panda within its limits", "a UR wrist with two axes in line"]


@pytest.mark.parametrize("strategy", ALL_STRATEGIES, ids=called)
@pytest.mark.parametrize("case", [*QUICK_SINGULAR, *slow(*(case for case in SINGULAR if case not in QUICK_SINGULAR))])
def test_singular_poses_as_start_and_as_target(case, strategy):
    name, pose, limits = SINGULAR[case]
    robot, ik, rng = arm(name), solver(name, strategy, limits=limits), np.random.default_rng(9)
    sigma = np.linalg.svd(robot.jacobian(pose), compute_uv=False)
    assert sigma[-1] < 1e-12 * sigma[0]
    solved = 0
    for _ in range(6):
        bent = np.clip(pose + rng.uniform(-0.4, 0.4, robot.n), robot.lower, robot.upper)
        for q0, target in ((pose, robot.pose(bent)), (bent, robot.pose(pose))):
            solution = ik.solve(target, q0=q0, max_iterations=500)
            assert np.isfinite(solution.q).all()
            assert solution.status is not Status.NOT_FINITE
            solved += solution.converged
    assert ik.solve(robot.pose(pose), q0=pose).iterations == 0
    if strategy in DESCENDING:
        assert solved >= 10, solved


SHOULDER = np.array([0.0, 0.0, 0.333])
UPPER_ARM, FOREARM = math.hypot(0.0825, 0.316), math.hypot(0.0825, 0.384)
"""The Panda's elbow stands off the lines between its shoulder, its elbow and its wrist [m]."""


def shoulder_to_wrist(q4):
    """Distance in a Panda, by the law of cosines [m]."""
    angle = q4 + math.atan2(0.0825, 0.316) + math.atan2(0.0825, 0.384)
    return math.sqrt(UPPER_ARM**2 + FOREARM**2 + 2 * UPPER_ARM * FOREARM * math.cos(angle))


def direction(rng):
    """Forwards, where the joints of the shoulder are within their limits, and neither straight up nor far down."""
    azimuth, elevation = rng.uniform(-2, 2), rng.uniform(-0.1, 1.2)
    around = math.cos(elevation)
    return np.array([around * math.cos(azimuth), around * math.sin(azimuth), math.sin(elevation)])


class TestOutOfReach:
    """The distances are known in closed form."""

    CASES = (
        ("panda", "panda_link5", SHOULDER, UPPER_ARM + FOREARM),
        ("ur5e", "wrist_1_link", np.array([0.0, 0.0, 0.1625]), math.hypot(0.425 + 0.3922, 0.1333)),
    )

    def test_the_closed_forms_are_those_of_the_arms(self):
        panda, ur5e = arm("panda"), arm("ur5e")
        for q4 in (-3.0, -1.5, -0.467, -0.07):
            wrist = panda.position([0.3, 0.4, 0.5, q4, 0.0, 0.0, 0.0], "panda_link5")
            assert np.linalg.norm(wrist - SHOULDER) == pytest.approx(shoulder_to_wrist(q4), abs=1e-12)
        wrist = ur5e.position([0.3, -0.4, 0.0, 0.5, 0.6, 0.7], "wrist_1_link")
        assert np.linalg.norm(wrist - self.CASES[1][2]) == pytest.approx(self.CASES[1][3], abs=1e-12)

    @pytest.mark.parametrize(
        ("name", "frame", "shoulder", "reach"), [CASES[0], pytest.param(*CASES[1], marks=pytest.mark.slow)]
    )
    @pytest.mark.parametrize("strategy", ALL_STRATEGIES, ids=called)
    def test_a_target_too_far_away_ends_at_the_closest_posture(self, strategy, name, frame, shoulder, reach):
        ik, rng = solver(name, strategy, frame, "position"), np.random.default_rng(0)
        q0 = arm(name).keyframes["home"][: ik.robot.n]
        for _ in range(20):
            distance = reach * rng.uniform(1.1, 3)
            target = shoulder + distance * direction(rng)
            solution = ik.solve(target, q0=q0, max_iterations=5000 if strategy in DESCENDING else 300)
            assert solution.position_error >= distance - reach - 1e-12
            assert not solution.converged
            if strategy in DESCENDING:
                assert solution.status is Status.LOCAL_MINIMUM
                assert solution.position_error <= distance - reach + 1e-8
            else:
                assert solution.status in (Status.LOCAL_MINIMUM, Status.STALLED, Status.ITERATION_LIMIT)

    @pytest.mark.parametrize("strategy", ALL_STRATEGIES, ids=called)
    def test_a_target_too_close_ends_at_a_limit(self, strategy):
        """The elbow cannot fold so far that the wrist comes to the shoulder."""
        ik, rng = solver("panda", strategy, "panda_link5", "position"), np.random.default_rng(3)
        q0 = arm("panda").keyframes["home"][: ik.robot.n]
        nearest = shoulder_to_wrist(arm("panda").lower[3])
        for _ in range(6):
            away = rng.uniform(0.03, 0.1)
            solution = ik.solve(SHOULDER + away * direction(rng), q0=q0)
            assert solution.position_error >= nearest - away - 1e-12
            assert not solution.converged
            if strategy in DESCENDING:
                assert solution.status is Status.LIMITS
                assert solution.active_limits == ("panda_joint4",)
                assert solution.position_error <= nearest - away + 1e-8

    @pytest.mark.parametrize("strategy", DESCENDING)
    def test_exactly_as_far_as_it_reaches_is_reached(self, strategy):
        """A double root: the arm is straight there, and the last digits come slowly."""
        ik, rng = solver("panda", strategy, "panda_link5", "position"), np.random.default_rng(3)
        for _ in range(3):
            target = SHOULDER + (UPPER_ARM + FOREARM - 1e-9) * direction(rng)
            assert ik.solve(target, q0=arm("panda").keyframes["home"][: ik.robot.n]).converged


@pytest.mark.parametrize("name", ["panda", *slow("ur5e")])
@pytest.mark.parametrize(("strategy", "most"), [("damped", 60), ("hybrid", 90), ("newton", 120), (UNCHECKED, 60)])
def test_from_the_limits_a_hundred_targets_are_found(name, strategy, most):
    """Every joint begins at one of its limits; ``most`` is the mean of the calls of all attempts."""
    robot, ik, rng = arm(name), solver(name, strategy), np.random.default_rng(5)
    solutions = []
    for _ in range(100):
        q0 = np.where(rng.random(robot.n) < 0.5, robot.lower, robot.upper)
        solutions.append(ik.solve(robot.pose(robot.random_configuration(rng)), q0=q0, restarts=100))
    assert all(solution.converged for solution in solutions)
    iterations = [solution.iterations for solution in solutions]
    assert np.mean(iterations) < most
    assert max(iterations) < 12 * most


@pytest.mark.parametrize("strategy", ["damped", "hybrid", "newton"])
def test_between_limits_the_error_falls_in_every_step(strategy):
    robot, ik, rng = arm("panda"), solver("panda", strategy), np.random.default_rng(6)
    for _ in range(20):
        q0 = np.where(rng.random(7) < 0.5, robot.lower, robot.upper)
        trace = ik.solve(robot.pose(robot.random_configuration(rng)), q0=q0, max_iterations=200, trace=True).trace
        V = np.append(trace.V, trace.error[-1] ** 2 / 2)
        assert (V[1:] <= V[:-1] * (1 + 1e-13)).all()
