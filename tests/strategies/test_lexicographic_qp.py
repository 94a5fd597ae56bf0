"""Levels of priority: each one's optimum by other solvers, the recursion inside it, ranks that fall, whole solves."""

from __future__ import annotations

import functools
import math
from types import SimpleNamespace

import casadi
import numpy as np
import pytest
from scipy.optimize import lsq_linear, minimize

import jtik
from jtik.qp import Conic
from jtik.testing import check_strategy
from jtik_formulations import JointCentering, LexicographicQP, ProjectedGradient
from jtik_formulations.strategies._parts.levels import DEFINITE, descend

from ..conftest import dh_arm, planar, planar_points, report_at, shared_solver

BARE = LexicographicQP(damping=0.0, q_limit=math.inf, backtracking=False)
"""Only the quadratic programs."""

STRICT = 1e-9
"""How exactly a higher level keeps its value whatever the lower ones want, with steps damped as by default."""

DAMPED = 0.1

SLACK = 1e-6
"""Of sums of squares of order one: without damping rows are kept to 1e-8, and the reduced QP has a margin of
1e-10 where a level above hardly depends on a limit."""


def solved(program):
    """The solution of a quadratic program of numbers."""
    data = [casadi.DM(part) for part in program.data()]
    x, _, box = Conic().function(program.size, program.row_count)(*data)
    return SimpleNamespace(x=casadi.SX(x), box_multipliers=casadi.SX(box))


def answer(J, r, levels, low, high, **options):
    """The lexicographic step of numbers, (n,)."""
    box = casadi.SX(low), casadi.SX(high)
    found = descend(casadi.SX(J), casadi.SX(r), levels, box, solved, **options)
    return np.array(casadi.DM(found.dq)).ravel()


def least_after(J, r, above, fixed, low, high):
    """min |J x + r| over above x = above fixed and the box, by bounded least squares with x = fixed + Z y."""
    Z = np.linalg.svd(above)[2][np.linalg.matrix_rank(above) :].T
    P, q = J @ Z, J @ fixed + r
    G, h = np.vstack([Z, -Z]), np.maximum(np.concatenate([high - fixed, fixed - low]), 0)
    y = minimize(
        lambda y: np.sum((P @ y + q) ** 2),
        np.zeros(Z.shape[1]),
        jac=lambda y: 2 * P.T @ (P @ y + q),
        constraints={"type": "ineq", "fun": lambda y: h - G @ y, "jac": lambda y: -G},
        method="SLSQP",
        options={"ftol": 1e-16, "maxiter": 1000},
    ).x
    return np.sum((P @ y + q) ** 2)


@pytest.mark.quick(1)
@pytest.mark.parametrize("size", [0.05, 0.3, 3.0])
def test_each_level_is_optimal_within_the_box_after_those_above(size, rng):
    """Two levels of random rows: SciPy's bounded least squares for the first, a reduced QP for the second.

    Worse than they are by at most what the curvature that keeps the QP of a level definite adds.
    """
    for _ in range(20):
        J, r = rng.normal(size=(5, 7)), rng.normal(size=5)
        low, high = -size * rng.uniform(0, 1, 7), size * rng.uniform(0, 1, 7)
        low[rng.integers(7)] = 0.0  # a joint at its limit
        x = answer(J, r, ((0, 1), (2, 3, 4)), low, high)
        assert (x >= low).all()
        assert (x <= high).all()
        tied = DEFINITE * np.sum(J**2) * 16 * np.sum(np.maximum(-low, high) ** 2)
        first = lsq_linear(J[:2], -r[:2], (low - 1e-15, high + 1e-15), tol=1e-14)
        assert np.sum((J[:2] @ x + r[:2]) ** 2) <= 2 * first.cost + tied + SLACK
        best = least_after(J[2:], r[2:], J[:2], x, low, high)
        assert np.sum((J[2:] @ x + r[2:]) ** 2) <= best + tied + SLACK


@pytest.mark.slow
def test_a_lower_level_cannot_change_a_higher_one(rng):
    for _ in range(20):
        J, r = rng.normal(size=(4, 6)), rng.normal(size=4)
        low, high = -rng.uniform(0, 0.4, 6), rng.uniform(0, 0.4, 6)
        alone = answer(J[:2], r[:2], ((0, 1),), low, high, damping=DAMPED)
        for wish in (r[2:], 100 * r[2:], -r[2:]):
            x = answer(J, np.append(r[:2], wish), ((0, 1), (2, 3)), low, high, damping=DAMPED)
            assert J[:2] @ x == pytest.approx(J[:2] @ alone, abs=STRICT)


@pytest.mark.quick(1)
@pytest.mark.parametrize("order", [((0, 1), (2, 3, 4), (5,)), ((5,), (2, 4), (0, 1, 3))])
def test_without_limits_it_is_the_recursion_of_pseudo_inverses(order, rng):
    """Siciliano and Slotine: x <- x - (J_k N)+ (r_k + J_k x), N <- N - (J_k N)+ J_k N."""
    for _ in range(10):
        J, r = rng.normal(size=(6, 8)), rng.normal(size=6)
        x, N = np.zeros(8), np.eye(8)
        for level in map(list, order):
            inverse = np.linalg.pinv(J[level] @ N, rcond=1e-10)
            x, N = x - inverse @ (r[level] + J[level] @ x), N - inverse @ J[level] @ N
        assert answer(J, r, order, np.full(8, -1e3), np.full(8, 1e3)) == pytest.approx(x, abs=1e-10)


class TestRank:
    def test_a_level_that_repeats_one_above_it_changes_nothing(self, rng):
        """Its rows lie in the span of those above, exactly or to rounding."""
        J, r = rng.normal(size=(2, 6)), rng.normal(size=2)
        box = np.full(6, -10.0), np.full(6, 10.0)
        alone = answer(J, r, ((0, 1),), *box)
        for mixed in (np.eye(2), rng.normal(size=(2, 2)), np.ones((2, 2))):
            x = answer(np.vstack([J, mixed @ J]), np.append(r, [5.0, -7.0]), ((0, 1), (2, 3)), *box)
            assert x == pytest.approx(alone, abs=STRICT)

    def test_rows_that_repeat_each_other_within_a_level(self, rng):
        """Two targets for the same row: their mean, and the level below uses all the remaining freedom."""
        J, r = rng.normal(size=(3, 6)), np.array([1.0, 3.0, 0.5])
        J[1] = J[0]
        x = answer(J, r, ((0, 1), (2,)), np.full(6, -10.0), np.full(6, 10.0))
        assert J[0] @ x == pytest.approx(-2.0, abs=STRICT)
        assert J[2] @ x == pytest.approx(-0.5, abs=STRICT)

    @pytest.mark.parametrize("apart", [1e-1, 1e-3, 1e-6, 1e-9, 1e-12, 0.0])
    def test_rows_that_nearly_repeat_one_above(self, apart, rng):
        """An algorithmic singularity: the step stays in its box and the higher level keeps its value."""
        J, r = rng.normal(size=(3, 6)), np.array([0.1, -0.2, 1.0])
        J[2] = J[0] + apart * J[2]
        low, high = np.full(6, -0.5), np.full(6, 0.5)
        alone = answer(J[:2], r[:2], ((0, 1),), low, high)
        x = answer(J, r, ((0, 1), (2,)), low, high)
        assert np.abs(x).max() <= 0.5
        assert J[:2] @ x == pytest.approx(J[:2] @ alone, abs=STRICT)

    @pytest.mark.parametrize("bend", [0.0, 1e-12, 1e-9, 1e-6, 1e-3])
    @pytest.mark.parametrize("levels", [1, 2])
    def test_a_straight_arm_is_pulled_inwards(self, bend, levels):
        """Rank is lost, or nearly: the strict QP of that step has no solution, the solve continues."""
        robot = planar(6)
        tasks = [jtik.FrameTask("tip"), jtik.FrameTask("link4", name="elbow", priority=1)][:levels]
        q0 = bend * np.array([0.0, 1.0, -1.0, 1.0, 1.0, -1.0])
        goal = np.array([0.3, 0.6, -0.5, 0.2, 0.4, -0.3])
        points = planar_points(goal)
        tip = np.array([np.linalg.norm(points[-1]), 0.0])
        turn = -np.arctan2(points[-1, 1], points[-1, 0])
        elbow = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]) @ points[2]
        target = tip if levels == 1 else {"tip": tip, "elbow": elbow}
        solution = shared_solver(robot, tasks, strategy="lexicographic_qp").solve(target, q0=q0)
        assert np.linalg.norm(planar_points(solution.q)[-1] - tip) < 1e-6
        assert solution.converged


class TestSteps:
    def test_the_step_of_three_levels_is_the_recursion(self, rng):
        """On a spatial arm with its tasks listed in another order than their priorities."""
        robot = dh_arm(8, 3)
        frames = robot.frame_names
        tasks = [
            jtik.FrameTask(frames[5], "position", axes="z", name="low", priority=5),
            jtik.FrameTask("tip", "position", name="high"),
            jtik.FrameTask("tip", "orientation", name="middle", priority=2),
        ]
        ik = shared_solver(robot, tasks, strategy=BARE, limits=False)
        for _ in range(5):
            q = rng.uniform(-1, 1, 8)
            at = robot.pose(q + rng.uniform(-0.1, 0.1, 8))
            target = {"low": robot.pose(q + 0.1, frames[5]), "high": at, "middle": at}
            seen = report_at(ik, q, target)
            x, N = np.zeros(8), np.eye(8)
            for rows in ([1, 2, 3], [4, 5, 6], [0]):
                J, e = seen.jacobian[rows], seen.error[rows]
                inverse = np.linalg.pinv(J @ N, rcond=1e-9)
                x, N = x - inverse @ (e + J @ x), N - inverse @ J @ N
            ik.reset()
            assert ik.step(q, target).q - q == pytest.approx(x, rel=1e-8, abs=1e-9)

    def test_a_limit_affects_the_lowest_level_first(self, rng):
        """The end effector moves as with its task alone, by other joints."""
        robot = planar(7, lower=-0.9, upper=0.9)
        tasks = [jtik.FrameTask("tip"), jtik.FrameTask("link4", name="elbow", priority=1)]
        strategy = LexicographicQP(backtracking=False)
        both = shared_solver(robot, tasks, strategy=strategy)
        alone = shared_solver(robot, tasks[0], strategy=strategy)
        for _ in range(10):
            q = rng.choice([-0.9, 0.2, 0.9], 7)
            tip = planar_points(q)[-1] + rng.uniform(-0.1, 0.1, 2)
            both.reset()
            alone.reset()
            J = report_at(alone, q, tip).jacobian
            dq = both.step(q, {"tip": tip, "elbow": rng.uniform(-4, 4, 2)}).q - q
            assert J @ dq == pytest.approx(J @ (alone.step(q, tip).q - q), abs=STRICT)

    def test_quadratic_programs_can_be_inspected(self):
        tasks = [jtik.FrameTask("tip"), jtik.FrameTask("link3", name="elbow", priority=1)]
        ik = shared_solver(planar(4), tasks, criteria=JointCentering(), strategy="lexicographic_qp")
        target = {"tip": [2.0, 1.0], "elbow": [1.0, 1.0]}
        for name, rows in (("level 0", 0), ("level 1", 2), ("null-space step", 4)):
            problem = ik.build([0.3] * 4, target, qp=name)
            assert (0 if problem.A is None else len(problem.A)) == rows


TIP = np.array([3.0, 2.5])


@functools.cache
def end_effector_above_elbow(n, limit, elbow, criteria):
    """A solver for a planar arm: the end effector first, and the end of a link below it."""
    tasks = [jtik.FrameTask("tip"), jtik.FrameTask(elbow, name="elbow", priority=1)]
    robot = planar(n, lower=-limit, upper=limit)
    return shared_solver(robot, tasks, criteria=criteria, strategy="lexicographic_qp")


CENTERING = JointCentering()


@pytest.mark.thinned
@pytest.mark.parametrize("limit", [math.inf, 1.2, 0.8])
@pytest.mark.parametrize("elbow", [(0.5, -1.5), (-3.0, 3.0), (0.0, 3.5)])
@pytest.mark.parametrize("with_criterion", [False, True])
def test_tasks_that_contradict_each_other(limit, elbow, with_criterion):
    """The end effector arrives; the elbow is as close as a local search over the postures on target finds."""
    ik = end_effector_above_elbow(6, limit, "link4", CENTERING if with_criterion else None)
    solution = ik.solve({"tip": TIP, "elbow": elbow}, q0=[0.2] * 6)
    points = planar_points(solution.q)
    assert np.linalg.norm(points[-1] - TIP) < STRICT
    assert np.abs(solution.q).max() <= limit

    def missed(q):
        return np.sum((planar_points(q)[2] - elbow) ** 2)

    best = minimize(
        missed,
        solution.q,
        method="SLSQP",
        bounds=None if limit == math.inf else [(-limit, limit)] * 6,
        constraints={"type": "eq", "fun": lambda q: planar_points(q)[-1] - TIP},
        options={"ftol": 1e-14, "maxiter": 300},
    )
    assert missed(solution.q) <= best.fun + 1e-6
    assert not solution.converged
    assert solution.status is jtik.Status.PRIORITIES
    left = [each.amount for each in solution.relaxed if each.name == "task 'elbow'"]
    assert left == pytest.approx([math.sqrt(missed(solution.q))])


def test_the_criterion_comes_below_all_tasks():
    """Two tasks that can both be met, and the minimum of H among the postures that do."""
    robot, q = planar(8, lower=-2.0, upper=2.0), np.linspace(0.6, -0.2, 8)
    tasks = [jtik.FrameTask("tip"), jtik.FrameTask("link5", name="elbow", priority=1)]
    ik = shared_solver(robot, tasks, criteria=JointCentering(), strategy="lexicographic_qp")
    tip, elbow = planar_points(q)[-1], planar_points(q)[3]
    solution = ik.solve({"tip": tip, "elbow": elbow}, q0=q + 0.2)
    assert solution.status is jtik.Status.CONVERGED

    def missed(at):
        return np.concatenate([planar_points(at)[-1] - tip, planar_points(at)[3] - elbow])

    best = minimize(
        lambda at: at @ at / 2,
        solution.q,
        method="SLSQP",
        constraints={"type": "eq", "fun": missed},
        options={"ftol": 1e-15},
    )
    assert solution.criteria["joint_centering"] == pytest.approx(best.fun, abs=1e-9)


def test_two_arms_on_one_body(rng):
    """Two arms on one trunk: each level is met as far as the higher one allows."""
    joints = [
        jtik.Joint("trunk", jtik.JointType.REVOLUTE, "base", "trunk", lower=-1.0, upper=1.0),
        *_arm("left", (0.3, 0.2)),
        *_arm("right", (0.3, -0.2)),
    ]
    robot = jtik.Robot(joints)
    tasks = [jtik.FrameTask("left tip", name="left"), jtik.FrameTask("right tip", name="right", priority=1)]
    tasks = [jtik.FrameTask(t.frame, axes="xy", name=t.name, priority=t.priority) for t in tasks]
    ik = shared_solver(robot, tasks, criteria=JointCentering(), strategy="lexicographic_qp")
    goal = rng.uniform(-0.8, 0.8, robot.n)
    target = {"left": robot.position(goal, "left tip"), "right": robot.position(goal, "right tip")}
    solution = ik.solve(target, q0=goal + 0.2)
    assert solution.converged
    far = target | {"right": np.array([9.0, 0.0, 0.0])}
    solution = ik.solve(far, q0=goal + 0.2)
    assert robot.position(solution.q, "left tip")[:2] == pytest.approx(target["left"][:2], abs=1e-8)


def _arm(side, place):
    shoulder, length = np.eye(4), np.eye(4)
    shoulder[:2, 3], length[0, 3] = place, 0.5
    parent, joints = "trunk", []
    for k in range(3):
        child = f"{side} {k}"
        origin = shoulder if k == 0 else length
        joints.append(
            jtik.Joint(f"{side} joint {k}", jtik.JointType.REVOLUTE, parent, child, origin=origin, lower=-2, upper=2)
        )
        parent = child
    return [*joints, jtik.Joint(f"{side} hand", jtik.JointType.FIXED, parent, f"{side} tip", origin=length)]


@pytest.mark.thinned
@pytest.mark.parametrize("start", [(1.0,) * 5, (-1.0, 1.0, -1.0, 1.0, -1.0), (5.0,) * 5, (0.0,) * 5])
@pytest.mark.parametrize("target", [(2.0, 1.0), (-3.0, 0.0), (0.0, 0.0), (50.0, 0.0)])
def test_at_limits_and_outside_them(start, target):
    ik = end_effector_above_elbow(5, 1.0, "link3", CENTERING)
    solution = ik.solve({"tip": target, "elbow": (1.0, 1.0)}, q0=start, max_iterations=200)
    assert np.isfinite(solution.q).all()
    assert np.abs(solution.q).max() <= 1.0
    assert solution.status not in (jtik.Status.UNSOLVED, jtik.Status.NOT_FINITE)


@pytest.mark.slow
def test_the_contract_without_damping():
    check_strategy(LexicographicQP(damping=0.0), samples=1)


@pytest.mark.parametrize(
    ("options", "name"),
    [({"damping": -1.0}, "damping"), ({"q_limit": 0.0}, "q_limit"), ({"secondary": ProjectedGradient()}, "secondary")],
)
def test_options_out_of_range_are_refused(options, name):
    with pytest.raises(jtik.ArgumentError, match=name):
        LexicographicQP(**options)
