"""Saddle escapes: a straight or folded arm leaves a saddle point of the error, and stays at a minimum.

Its tests are thinned: ``--full`` runs all of them.
"""

from __future__ import annotations

import functools

import numpy as np
import pytest

import jtik
from jtik_formulations import JointCentering, ObstacleAvoidance

from ...conftest import dh_arm, planar, planar_points, shared_solver
from ..conftest import EVERY_STRATEGY

pytestmark = pytest.mark.thinned(together=True, times=3)

STRAIGHT = np.zeros(4)
FOLDED = np.array([0.0, np.pi, 0.0, 0.0])
"""One link out, three back: the tip is at (-2, 0)."""

COLLINEAR = JointCentering() + 0.1 * ObstacleAvoidance(jtik.Point((6.0, 0.0)))
"""Springs to zero angles, and an obstacle on the line of the arm."""


@functools.cache
def solver(robot, strategy, criteria=None):
    return jtik.InverseKinematics(robot, jtik.FrameTask(), strategy=strategy, criteria=criteria)


def solve(q0, target, strategy="hybrid", **options):
    criteria = options.pop("criteria", None)
    robot = options.pop("robot", planar(len(q0)))
    build = solver.__wrapped__ if options.pop("fresh", False) else solver
    ik = build(robot, strategy, criteria)
    return ik.solve(target, q0=q0, max_iterations=5000, position_tolerance=1e-4, **options)


@pytest.mark.parametrize("strategy", EVERY_STRATEGY)
@pytest.mark.parametrize("r", [0.5, 2.0, 3.5, 3.999, -1.5])
@pytest.mark.parametrize("turn", [0.0, 0.7])
def test_a_straight_arm_reaches_a_target_on_its_own_line(strategy, r, turn):
    q0 = np.array([turn, 0.0, 0.0, 0.0])
    target = r * np.array([np.cos(turn), np.sin(turn)])
    solution = solve(q0, target, strategy)
    assert solution.converged
    assert planar_points(solution.q)[-1] == pytest.approx(target, abs=1e-4)
    if turn == 0.0:  # otherwise rounding bends the arm
        assert solution.escapes >= 1


@pytest.mark.parametrize("strategy", EVERY_STRATEGY)
@pytest.mark.parametrize("x", [-3.5, -1.0, 1.0])
def test_a_folded_arm_reaches_a_target_on_its_own_line(strategy, x):
    solution = solve(FOLDED, (x, 0.0), strategy)
    assert solution.converged
    assert planar_points(solution.q)[-1] == pytest.approx((x, 0), abs=1e-4)


@pytest.mark.parametrize("strategy", EVERY_STRATEGY)
def test_an_escape_is_deterministic(strategy):
    first, again = (solve(STRAIGHT, (2.0, 0.0), strategy, trace=True, fresh=fresh) for fresh in (False, True))
    assert first.q.tolist() == again.q.tolist()
    assert first.trace.q.tolist() == again.trace.q.tolist()


def test_the_trace_and_the_text_show_it():
    solution = solve(STRAIGHT, (2.0, 0.0), trace=True)
    assert f"escapes     {solution.escapes}" in repr(solution)
    assert solution.trace.escaped.sum() == solution.escapes == 1
    assert solution.trace.q[0].tolist() == STRAIGHT.tolist()  # the start is in the trace
    assert len(solution.trace) == solution.iterations


@pytest.mark.parametrize("strategy", EVERY_STRATEGY)
def test_V_falls_in_an_escape_too(strategy):
    V = solve(STRAIGHT, (2.0, 0.0), strategy, trace=True).trace.V
    assert (np.diff(V) <= 0).all()


@pytest.mark.parametrize("strategy", EVERY_STRATEGY)
def test_a_criterion_without_gradient_at_the_saddle_does_not_prevent_the_escape(strategy):
    """Springs to zero angles and obstacles on the line of the arm have no gradient across it."""
    solution = solve(STRAIGHT, (2.0, 0.0), strategy, criteria=COLLINEAR, until="reached")
    assert solution.converged
    assert solution.escapes >= 1


def test_the_criterion_chooses_the_side():
    for side in (1.0, -1.0):
        solution = solve(STRAIGHT, (2.0, 0.0), criteria=JointCentering(preferred=side * np.array([0.5, -0.3, -0.3, 0])))
        assert np.sign(solution.q[0]) == side


def test_a_step_escapes_too():
    ik = shared_solver(planar(4), jtik.FrameTask())
    step = ik.step(STRAIGHT, (2.0, 0.0))
    assert step.escaped
    q = step.q
    assert planar_points(q)[-1] != pytest.approx((4, 0), abs=1e-3)
    assert step.position_error == pytest.approx(np.linalg.norm(planar_points(q)[-1] - (2, 0)), abs=1e-12)
    for _ in range(30):
        q = ik.step(q, (2.0, 0.0)).q
    assert planar_points(q)[-1] == pytest.approx((2, 0), abs=1e-6)


@pytest.mark.parametrize("strategy", EVERY_STRATEGY)
def test_limits_are_kept_in_an_escape(strategy):
    robot = planar(4, lower=(-0.1, -2, 0, -2), upper=(2, 2, 2, 0))
    solution = solve(STRAIGHT, (2.0, 0.0), strategy, robot=robot, trace=True)
    assert solution.converged
    assert (solution.trace.q >= robot.lower).all()
    assert (solution.trace.q <= robot.upper).all()


@pytest.mark.parametrize("strategy", EVERY_STRATEGY)
def test_a_joint_at_one_limit_can_move_away_from_it(strategy):
    """Every joint is at a limit, but can move away from it: the arm is only straight."""
    robot = planar(3, lower=(-2.0, 0.0, 0.0), upper=(2.0, 2.0, 2.0))
    solution = solve(np.zeros(3), (1.5, 0.0), strategy, robot=robot)
    assert solution.converged


def test_a_spatial_arm_gets_out_of_its_outstretched_pose():
    half = np.pi / 2
    robot = jtik.Robot.from_dh([(0, half, 0, 0), (0.5, 0, 0, 0), (0.5, 0, 0, 0)])
    solution = solve(np.zeros(3), (0.4, 0.0, 0.0), robot=robot)
    assert solution.converged
    assert solution.escapes >= 1


class TestOutOfReach:
    @pytest.mark.parametrize("criteria", [None, JointCentering(), ObstacleAvoidance(jtik.Circle((4.0, 3.0), 0.5))])
    @pytest.mark.parametrize("angle", [0.0, 1.0])
    def test_the_arm_stretches_towards_the_target_and_the_status_is_local_minimum(self, criteria, angle, rng):
        ik = shared_solver(planar(10), jtik.FrameTask(), criteria=criteria)
        target = 10.5 * np.array([np.cos(angle), np.sin(angle)])
        for q0 in (rng.uniform(-0.5, 0.5, 10), rng.uniform(-1, 1, 10)):
            solution = ik.solve(target, q0=q0)
            assert solution.status is jtik.Status.LOCAL_MINIMUM
            assert solution.position_error == pytest.approx(0.5, abs=1e-4)
            assert not solution.converged
            assert "out of reach, or a local minimum" in repr(solution)

    @pytest.mark.parametrize("strategy", EVERY_STRATEGY)
    def test_a_straight_arm_with_its_target_beyond_stays(self, strategy):
        solution = solve(np.zeros(3), (3.5, 0.0), strategy)
        assert solution.status is jtik.Status.LOCAL_MINIMUM
        assert solution.escapes == 0
        assert solution.q.tolist() == [0, 0, 0]

    @pytest.mark.parametrize("strategy", EVERY_STRATEGY)
    def test_a_single_link_turns_to_where_its_target_is(self, strategy):
        solution = solve(np.zeros(1), (-2.0, 0.0), strategy)
        # with little damping at the closest posture every step is many times too long, and halving it creeps there
        creeps = strategy in ("damped_constant", "nakamura")
        creeping = (jtik.Status.STALLED, jtik.Status.ITERATION_LIMIT) if creeps else ()
        assert solution.status in (jtik.Status.LOCAL_MINIMUM, *creeping)
        assert solution.position_error == pytest.approx(1.0, abs=1e-3 if creeps else 1e-6)

    def test_too_near_is_out_of_reach_as_well(self):
        """A long and a short link cannot reach the base."""
        robot = jtik.Robot.planar([2.0, 0.5])
        solution = solve(np.array([0.3, 0.8]), (0.5, 0.0), robot=robot)
        assert solution.status is jtik.Status.LOCAL_MINIMUM
        assert solution.position_error == pytest.approx(1.0, abs=1e-4)

    def test_the_error_of_a_pose_out_of_reach_is_that_of_an_optimiser(self, rng):
        from scipy.optimize import least_squares

        robot = dh_arm(6, 4)
        ik = shared_solver(robot, jtik.FrameTask("tip", "pose"))
        for _ in range(3):
            q0 = robot.random_configuration(rng)
            target = robot.pose(robot.integrate(q0, rng.uniform(-0.2, 0.2, 6)))
            target[:3, 3] += 2.0
            solution = ik.solve(target, q0=q0)
            assert solution.status is jtik.Status.LOCAL_MINIMUM

            def error(q, t=target):
                return ik.solve(t, q0=q, max_iterations=0).error

            better = least_squares(error, solution.q, xtol=1e-14, ftol=1e-14, gtol=1e-12)
            assert np.linalg.norm(solution.error) <= np.linalg.norm(better.fun) + 1e-6


def test_a_saddle_without_escape_within_the_limits_is_singular():
    """Within limits 1e-8 rad wide the error cannot fall by more than rounding."""
    robot = jtik.Robot.planar(3, lower=-1e-8, upper=1e-8)
    solution = solve(np.zeros(3), (1.0, 0.0), robot=robot)
    assert solution.status is jtik.Status.SINGULAR


@pytest.mark.quick(1)
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_an_escape_keeps_clearances(side):
    """A row of circles beside the arm: the first second-order step that lowers V would sweep through them."""
    field = [jtik.Circle((x, 0.25 * side), 0.15) for x in (0.5, 1.5, 2.5, 3.5)]
    clearance = jtik.Clearance(ObstacleAvoidance(field, bodies="links"), safe=0.05)
    ik = shared_solver(planar(4), jtik.FrameTask(), strategy="hybrid+qp", clearances=clearance)
    trace = ik.solve((2.0, 0.0), q0=STRAIGHT, max_iterations=40, trace=True).trace
    assert trace.escaped.any()
    for start, end in zip(trace.q[:-1], trace.q[1:], strict=True):
        for share in np.linspace(0, 1, 9):
            points = np.vstack([[0.0, 0.0], planar_points(start + share * (end - start))])
            for circle in field:
                along = np.diff(points, axis=0)
                part = np.clip(((circle.center - points[:-1]) * along).sum(1), 0, 1)
                nearest = points[:-1] + part[:, None] * along
                assert np.linalg.norm(nearest - circle.center, axis=1).min() - circle.radius >= 0.05 - 1e-9


def test_a_clearance_can_forbid_every_escape():
    """Circles on both sides, as near as they may be: the arm can move to neither side."""
    field = [jtik.Circle((x, y), 0.15) for x in (0.5, 1.5, 2.5, 3.5) for y in (-0.25, 0.25)]
    clearance = jtik.Clearance(ObstacleAvoidance(field, bodies="links"), safe=0.1)
    ik = shared_solver(planar(4), jtik.FrameTask(), strategy="hybrid+qp", clearances=clearance)
    solution = ik.solve((2.0, 0.0), q0=STRAIGHT, max_iterations=40)
    assert solution.escapes == 0
    assert solution.q == pytest.approx(STRAIGHT, abs=1e-9)
    assert not solution.converged


class TestAnErrorThatNoMotionChanges:
    """A straight arm that moves in a plane, its target on its line and at a height that no motion changes.

    The height adds to V, not to its Hessian: the fall along the escape is found while it is above 1e-12 of V.
    """

    HEIGHTS = (0.0, 1e3, 3e5, 3e6, 1e8)

    @staticmethod
    def arm():
        return jtik.Robot.from_dh([{"a": 1.0, "alpha": 0.0, "d": 0.0, "theta": 0.0}] * 4)

    @staticmethod
    def expected_fall(robot):
        """V(0) - V(z / 2) of the arm in its plane, z the lowest eigenvector of the Hessian by differences."""

        def V(q):
            return float(np.sum((planar_points(q)[-1] - (2.0, 0.0)) ** 2)) / 2

        h, unit = 1e-3, np.eye(4)
        pairs = [[V(h * (a + b)) - V(h * a) - V(h * b) + V(0 * a) for b in unit] for a in unit]
        z = np.linalg.eigh(np.array(pairs))[1][:, 0]
        return V(0 * z) - V(z / 2)

    @pytest.mark.parametrize("height", HEIGHTS)
    def test_the_escape_is_found_while_the_fall_is_above_rounding_of_V(self, height):
        robot = self.arm()
        ik = shared_solver(robot, jtik.FrameTask(robot.tip))
        visible = self.expected_fall(robot) > 1e-12 * (4 + height**2) / 2
        assert visible == (height < 1e6)
        solution = ik.solve([2.0, 0.0, height], q0=STRAIGHT, max_iterations=5)
        assert (solution.escapes > 0) == visible
        if not visible:
            assert solution.status is jtik.Status.SINGULAR
            assert solution.q.tolist() == STRAIGHT.tolist()


class TestHowFarTheErrorCanStillFall:
    """One link of 1 m and a target at (d, 0): V = (1 + d^2 - 2 d cos q) / 2, V' = d sin q, V'' = d cos q."""

    @pytest.mark.parametrize("d", [2.0, 1e3])
    @pytest.mark.parametrize("q", [1e-3, -0.1, 1.2, 2.0, -2.0])
    def test_in_closed_form(self, d, q):
        ik = shared_solver(planar(1), jtik.FrameTask())
        slope, curvature = d * abs(np.sin(q)), d * np.cos(q)
        falls = slope**2 / (2 * curvature) if curvature > slope else slope - curvature / 2
        assert decrease(ik, q, d) == pytest.approx(falls, rel=1e-9)

    def test_a_joint_at_a_limit_that_the_error_pushes_outward_stays(self):
        ik = shared_solver(planar(1, lower=-0.5, upper=0.5), jtik.FrameTask())
        assert decrease(ik, 0.5, -2.0) == 0.0  # V falls beyond the limit
        assert decrease(ik, 0.5, 2.0) > 0.1  # V falls on the way back


def decrease(ik, q, d):
    """The possible decrease of V at q for a target at (d, 0)."""
    engine = ik._engine
    inputs = engine.solving._memory.inputs
    inputs.target[:] = d, 0.0
    return engine._escape.possible_decrease(np.array([q]), inputs)
