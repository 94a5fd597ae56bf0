"""Saturation in the null space: the published example, LP and QP oracles, the form with QPs, levels, limits."""

from __future__ import annotations

import functools
import inspect
import math

import casadi
import numpy as np
import pytest
import qpsolvers
from scipy.optimize import linprog, minimize

import jtik
from jtik.qp import Conic, QPRecorder
from jtik.testing import check_strategy
from jtik_formulations import SNS, SNSQP, Damped, JointCentering, ProjectedGradient
from jtik_formulations.strategies._parts.saturation import Saturation
from jtik_formulations.strategies.sns import sns
from jtik_formulations.strategies.sns_qp import QPScaling

from ..conftest import EXACT, dh_arm, planar, planar_jacobian, planar_points, shared_solver, slow

AGREE = 1e-8
"""Between an answer in closed form and one of a solver whose tolerances are 1e-8 to 1e-10."""

STRAIGHT = 1e-9
"""|J dq - s xdot| for numbers of order one: rounding times the condition of a basis, up to 1e6 among random ones."""

BARE = {"damping": 0.0, "backtracking": False, "q_limit": math.inf}

EXAMPLE_Q = np.array([1, -1, 1, -1]) * np.pi / 2
EXAMPLE_J = np.array([[-2.0, -1, -1, 0], [2, 2, 1, 1]])
EXAMPLE_XDOT = np.array([-4.0, -1.5])
EXAMPLE_BOUND = np.array([2.0, 2, 4, 4])
EXAMPLE = {
    1.0: ([2, -11 / 6, 11 / 6, -11 / 3], 1),
    1.5: ([2, -2, 26 / 11, -4], 8 / 11),
    2.0: ([2, -2, 26 / 11, -4], 6 / 11),
    3.0: ([2, -2, 26 / 11, -4], 4 / 11),
}


def inputs(m, n):
    sym = casadi.SX.sym
    return sym("J", m, n), sym("xdot", m), sym("lower", n), sym("upper", n), sym("wish", n)


def called(function):
    return lambda *arguments: [np.array(value).ravel() for value in function(*arguments)]


@functools.cache
def compiled(m, n, rule="optimal", rounds=None):
    """(J, xdot, lower, upper) -> dq, s."""
    J, xdot, lower, upper, _ = inputs(m, n)
    return called(casadi.Function("sns", [J, xdot, lower, upper], sns(J, xdot, lower, upper, rule=rule, rounds=rounds)))


@functools.cache
def wishing(m, n, rounds):
    """(J, xdot, lower, upper, wish) -> dq for the task, dq with the wish, s."""
    J, xdot, lower, upper, wish = inputs(m, n)
    task = Saturation.initial(lower, upper, rounds=rounds).with_task(J, xdot)
    outputs = [task.x, task.towards(wish).x, task.scale]
    return called(casadi.Function("wishing", [J, xdot, lower, upper, wish], outputs))


@functools.cache
def arm_solver(strategy):
    return shared_solver(planar(4), jtik.FrameTask(), strategy=strategy)


@functools.cache
def by_qp(m, n):
    """(J, xdot, lower, upper) -> dq, s by a QP that DAQP solves."""
    J, xdot, lower, upper, _ = inputs(m, n)
    recorder = QPRecorder(1e-7)
    task = QPScaling.initial(recorder.solve, lower, upper).with_task(J, xdot)
    (recorded,) = recorder.calls
    program = casadi.Function("program", [J, xdot, lower, upper], recorded.data())
    solver = Conic().function(n, recorded.qp.row_count)
    after = casadi.Function("after", [J, xdot, lower, upper, *recorded.result_symbols], [task.x, task.scale])
    solved = 1.0
    return lambda *arguments: [
        np.array(value).ravel() for value in after(*arguments, *solver(*program(*arguments)), solved)
    ]


def best(J, xdot, lower, upper, wish=None):
    """The largest s by HiGHS, and the dq closest to the wanted one among those that reach it by DAQP."""
    m, n = J.shape
    exact = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}
    found = linprog(
        np.append(np.zeros(n), -1.0),
        A_eq=np.column_stack([J, -xdot]),
        b_eq=np.zeros(m),
        bounds=[*zip(lower, upper, strict=True), (0, 1)],
        options=exact,
    )
    dq, s = found.x[:-1], found.x[-1]
    wish = np.zeros(n) if wish is None else wish
    exact = {"primal_tol": 1e-11, "dual_tol": 1e-11}
    return qpsolvers.solve_qp(np.eye(n), -wish, A=J, b=J @ dq, lb=lower, ub=upper, solver="daqp", **exact), s


def random_problem(rng, m, n):
    """Tasks from easy to ten times too fast; some joints at a limit, some without one."""
    J, xdot = rng.normal(size=(m, n)), rng.normal(size=m) * 10 ** rng.uniform(-1, 1)
    lower, upper = -rng.uniform(0.05, 1, n), rng.uniform(0.05, 1, n)
    if rng.random() < 0.3:
        upper[rng.integers(n)] = 0
    if rng.random() < 0.2:
        lower[rng.integers(n)] = -np.inf
    return J, xdot, lower, upper


SIZES = [(1, 4), (2, 4), (3, 4), (2, 7), (6, 7), (3, 10)]


class TestTheExample:
    """Unit 4R, q = (pi/2, -pi/2, pi/2, -pi/2), xdot = (-4, -1.5), |dq| <= (2, 2, 4, 4)."""

    @pytest.mark.thinned
    @pytest.mark.parametrize("times", EXAMPLE)
    @pytest.mark.parametrize(
        "solve", [compiled(2, 4), compiled(2, 4, "basic"), by_qp(2, 4)], ids=["sns", "basic", "qp"]
    )
    def test_on_matrices(self, solve, times):
        dq, s = solve(EXAMPLE_J, times * EXAMPLE_XDOT, -EXAMPLE_BOUND, EXAMPLE_BOUND)
        expected, scale = EXAMPLE[times]
        assert dq == pytest.approx(expected, abs=AGREE)
        assert s == pytest.approx(scale, abs=AGREE)

    @pytest.mark.thinned
    @pytest.mark.parametrize("times", EXAMPLE)
    @pytest.mark.parametrize(
        "strategy", [SNS(**BARE), SNS(rule="basic", **BARE), SNSQP(**BARE)], ids=["sns", "basic", "qp"]
    )
    def test_as_a_step_of_a_robot(self, strategy, times, monkeypatch):
        monkeypatch.setattr("jtik._step.distant_target.REACH", math.inf)  # the fastest tasks lead far out of reach
        robot = jtik.Robot.planar(4, lower=EXAMPLE_Q - EXAMPLE_BOUND, upper=EXAMPLE_Q + EXAMPLE_BOUND)
        ik = jtik.InverseKinematics(robot, jtik.FrameTask(), strategy=strategy)
        target = planar_points(EXAMPLE_Q)[-1] + times * EXAMPLE_XDOT
        expected, scale = EXAMPLE[times]
        assert ik.step(EXAMPLE_Q, target).q - EXAMPLE_Q == pytest.approx(expected, abs=AGREE)
        trace = ik.solve(
            target, q0=EXAMPLE_Q, max_iterations=1, trace=True, jump_limit=9.0
        ).trace  # the limits as they are
        assert trace.scale_0 == pytest.approx([scale], abs=AGREE)


class TestOnMatrices:
    @pytest.mark.quick(3)
    @pytest.mark.parametrize(("m", "n"), SIZES)
    def test_the_optimal_rule_and_the_quadratic_programs_are_optimal(self, m, n, rng):
        scaled = 0
        for _ in range(30):
            problem = random_problem(rng, m, n)
            expected, largest = best(*problem)
            scaled += largest < 1 - AGREE
            for solve, accuracy in ((compiled(m, n), AGREE), (by_qp(m, n), 10 * AGREE)):
                dq, s = solve(*problem)
                assert s == pytest.approx(largest, abs=AGREE)
                assert dq == pytest.approx(expected, abs=accuracy)
        assert 2 < scaled < 30

    @pytest.mark.thinned
    @pytest.mark.parametrize("rule", ["optimal", "basic"])
    @pytest.mark.parametrize(("m", "n"), SIZES)
    def test_limits_hold_and_the_direction_stays(self, rule, m, n, rng):
        for _ in range(30):
            J, xdot, lower, upper = random_problem(rng, m, n)
            dq, s = compiled(m, n, rule)(J, xdot, lower, upper)
            assert (dq >= lower).all()
            assert (dq <= upper).all()
            assert J @ dq == pytest.approx(s * xdot, abs=STRAIGHT)
            assert 0 <= s <= best(J, xdot, lower, upper)[1] + AGREE

    @pytest.mark.quick(1)
    @pytest.mark.parametrize("rounds", [1, 2, 5])
    def test_too_few_rounds_cost_speed_only(self, rounds, rng):
        short = 0
        for _ in range(30):
            J, xdot, lower, upper = random_problem(rng, 3, 10)
            wish = rng.normal(size=10)
            task, dq, s = wishing(3, 10, rounds)(J, xdot, lower, upper, wish)
            short += s < best(J, xdot, lower, upper)[1] - AGREE
            for each in (task, dq):
                assert (each >= lower).all()
                assert (each <= upper).all()
                assert J @ each == pytest.approx(s * xdot, abs=STRAIGHT)
        assert short > 0

    @pytest.mark.quick(3)
    @pytest.mark.parametrize(("m", "n"), SIZES)
    def test_a_null_space_displacement_is_followed_within_the_task_and_the_limits(self, m, n, rng):
        for _ in range(30):
            problem, wish = random_problem(rng, m, n), rng.normal(size=n)
            expected, largest = best(*problem, wish=wish)
            _, dq, s = wishing(m, n, 2 * n)(*problem, wish)
            assert s == pytest.approx(largest, abs=AGREE)
            assert dq == pytest.approx(expected, abs=AGREE)

    @pytest.mark.thinned
    @pytest.mark.parametrize("small", [1e-3, 1e-5, 1e-7, 0.0])
    @pytest.mark.parametrize(
        "solve", [compiled(2, 5), compiled(2, 5, "basic"), by_qp(2, 5)], ids=["sns", "basic", "qp"]
    )
    def test_near_and_at_rank_one(self, solve, small, rng):
        """A task along the strong direction is met as if the weak one did not exist."""
        for _ in range(20):
            strong, weak, side = rng.normal(size=5), small * rng.normal(size=5), rng.normal(size=2)
            side /= np.linalg.norm(side)
            across = np.array([-side[1], side[0]])
            J = np.outer(side, strong) + np.outer(across, weak)
            bound = np.full(5, 0.4)
            if small == 0 and solve is not compiled(2, 5, "basic"):
                reach = 0.4 * np.abs(strong).sum()  # every joint gives what it has
                for times in (0.5, 4.0):
                    dq, s = solve(J, times * reach * side, -bound, bound)
                    assert s == pytest.approx(min(1, 1 / times), abs=AGREE)
            dq, s = solve(J, 10 * side, -bound, bound)
            assert (np.abs(dq) <= bound).all()
            assert J @ dq == pytest.approx(s * 10 * side, abs=1e-7)

    @pytest.mark.parametrize(
        "solve", [compiled(2, 4), compiled(2, 4, "basic"), by_qp(2, 4)], ids=["sns", "basic", "qp"]
    )
    def test_a_task_of_zero_and_a_box_of_one_point(self, solve):
        open_box, shut = np.full(4, 1.0), np.zeros(4)
        dq, s = solve(EXAMPLE_J, np.zeros(2), -open_box, open_box)
        assert dq == pytest.approx(np.zeros(4), abs=EXACT)
        assert s == 1
        dq, s = solve(EXAMPLE_J, EXAMPLE_XDOT, shut, shut)
        assert dq == pytest.approx(np.zeros(4), abs=EXACT)
        assert s == pytest.approx(0, abs=EXACT)


class TestTheStep:
    STRATEGIES = (SNS(**BARE | {"damping": 0.1}), SNSQP(**BARE | {"damping": 0.1}))

    @pytest.mark.thinned
    @pytest.mark.parametrize(
        "strategy", [*STRATEGIES, SNS(rule="basic", **BARE | {"damping": 0.1})], ids=["sns", "qp", "basic"]
    )
    @pytest.mark.parametrize("kind", ["position", "pose"])
    def test_without_limits_it_is_the_damped_step(self, strategy, kind, rng):
        robot = dh_arm(7, 1)
        damped = Damped(damping=0.1, q_limit=math.inf, backtracking=False)
        one, other = (shared_solver(robot, jtik.FrameTask("tip", kind), strategy=s) for s in (strategy, damped))
        for _ in range(10):
            q, target = rng.uniform(-1, 1, 7), robot.pose(rng.uniform(-1, 1, 7))
            assert one.step(q, target).q == pytest.approx(other.step(q, target).q, abs=AGREE)

    @pytest.mark.slow
    def test_the_scale_is_the_largest_with_a_third_of_the_joints_at_limits(self, rng):
        robot = planar(10, lower=-1.0, upper=1.0)
        ik = shared_solver(robot, jtik.FrameTask(), strategy=SNS(**BARE))
        scaled = 0
        for _ in range(25):
            q = rng.uniform(-1, 1, 10)
            at = rng.permutation(10)[:3]
            q[at] = np.sign(q[at])
            J, xdot = planar_jacobian(q), planar_jacobian(q) @ rng.normal(size=10) * rng.uniform(0.5, 3.0)
            xdot *= min(1.0, 15.0 / np.linalg.norm(xdot))  # a step towards a distant target is made for a nearer one
            target = planar_points(q)[-1] + xdot
            trace = ik.solve(target, q0=q, max_iterations=1, trace=True, jump_limit=9.0).trace
            _, largest = best(J, xdot, -1.0 - q, 1.0 - q)
            scaled += largest < 1
            assert trace.scale_0 == pytest.approx([largest], abs=AGREE)
        assert scaled > 3

    @pytest.mark.thinned
    @pytest.mark.parametrize("criteria", [None, JointCentering()], ids=["alone", "centring"])
    @pytest.mark.parametrize("n", [4, 7])
    def test_both_strategies_take_the_same_steps(self, criteria, n, rng):
        """Starts inside, and with joints at their limits."""
        robot = planar(n, lower=-1.0, upper=1.0)
        strategies = SNS(), SNSQP()
        one, other = (shared_solver(robot, jtik.FrameTask(), criteria=criteria, strategy=s) for s in strategies)
        for _ in range(15):
            q = rng.uniform(-1, 1, n)
            q = np.where(rng.random(n) < 0.2, np.sign(q), q)
            target = planar_points(rng.uniform(-1, 1, n))[-1]
            one.reset()
            other.reset()
            assert one.step(q, target).q == pytest.approx(other.step(q, target).q, abs=1e-6)

    @pytest.mark.parametrize("strategy", [SNS(), SNS(rule="basic"), SNSQP()], ids=["sns", "basic", "qp"])
    def test_the_step_limit_scales_the_task(self, strategy):
        """|dq| <= 0.5 rad a joint, and the end effector keeps its direction to first order."""
        q, target = np.array([0.4, 0.5, -0.3, 0.6]), np.array([-1.0, 1.0])
        ik = shared_solver(planar(4), jtik.FrameTask(), strategy=strategy)
        dq = ik.step(q, target).q - q
        J, e = planar_jacobian(q), planar_points(q)[-1] - target
        asked = -J @ J.T @ np.linalg.solve(J @ J.T + 0.1 * (e @ e / 2) * np.eye(2), e)
        assert np.abs(dq).max() == pytest.approx(0.5, abs=AGREE)
        moved = J @ dq
        assert moved[0] * asked[1] == pytest.approx(moved[1] * asked[0], abs=1e-7)
        assert moved @ asked > 0

    def test_a_criterion_moves_the_null_space_only(self, rng):
        """-beta (I - J+ J) grad H beside the damped step, where no limit is near."""
        strategy = SNS(**BARE | {"damping": 0.1}, secondary=ProjectedGradient(step_limit=1e3, beta_max=0.1))
        ik = shared_solver(planar(6), jtik.FrameTask(), criteria=JointCentering(), strategy=strategy)
        for _ in range(10):
            q, target = rng.uniform(-1, 1, 6), rng.uniform(-3, 3, 2)
            J, e = planar_jacobian(q), planar_points(q)[-1] - target
            p = J.T @ np.linalg.solve(J @ J.T + 0.1 * (e @ e / 2) * np.eye(2), e)
            g = ik.solve(target, q0=q, max_iterations=0).gradient
            expected = -p - 0.1 * (g - np.linalg.pinv(J) @ J @ g)
            ik.reset()
            assert ik.step(q, target).q - q == pytest.approx(expected, abs=1e-9)


class TestLevels:
    ROBOT = jtik.Robot.planar(6, lower=-1.2, upper=1.2)

    def solver(self, strategy, count=2, **options):
        tasks = [
            jtik.FrameTask("tip", name="tip"),
            jtik.FrameTask("link4", priority=1, name="elbow"),
            jtik.FrameTask("link6", priority=2, axes="x", name="wrist"),
        ]
        return shared_solver(self.ROBOT, tasks[:count], strategy=strategy, **options)

    def problem(self, rng):
        q = np.clip(rng.uniform(-1.5, 1.5, 6), -1.2, 1.2)
        points = planar_points(q)
        names = zip(("tip", "elbow", "wrist"), (5, 2, 4), strict=True)
        target = {name: points[i] + rng.uniform(-0.8, 0.8, 2) for name, i in names}
        return q, target

    @pytest.mark.slow
    @pytest.mark.parametrize(
        "strategy",
        [
            pytest.param(SNS(**BARE), id="sns"),
            pytest.param(SNS(rule="basic", **BARE), id="basic", marks=pytest.mark.slow),
            pytest.param(SNSQP(**BARE), id="qp", marks=pytest.mark.slow),
        ],
    )
    def test_lower_levels_do_not_disturb_higher_ones(self, strategy, rng):
        solvers = [self.solver(strategy, count) for count in (1, 2, 3)]
        moved = 0.0
        for _ in range(8):
            q, target = self.problem(rng)
            steps = []
            for count, ik in enumerate(solvers, 1):
                wanted = dict(list(target.items())[:count]) if count > 1 else target["tip"]
                ik.reset()
                steps.append(ik.step(q, wanted).q - q)
            tip = planar_jacobian(q)
            elbow = np.hstack([planar_jacobian(q[:3]), np.zeros((2, 3))])
            assert tip @ steps[1] == pytest.approx(tip @ steps[0], abs=AGREE)
            assert np.vstack([tip, elbow]) @ steps[2] == pytest.approx(np.vstack([tip, elbow]) @ steps[1], abs=AGREE)
            for dq in steps:
                assert (np.abs(q + dq) <= 1.2 + EXACT).all()
            moved = max(moved, np.abs(steps[1] - steps[0]).max(), np.abs(steps[2] - steps[1]).max())
        assert moved > 0.1

    @pytest.mark.slow
    def test_both_strategies_agree(self, rng):
        one, other = self.solver(SNS(rounds=12, **BARE)), self.solver(SNSQP(**BARE))
        for _ in range(8):
            q, target = self.problem(rng)
            del target["wrist"]
            one.reset()
            other.reset()
            assert one.step(q, target).q == pytest.approx(other.step(q, target).q, abs=1e-6)

    @pytest.mark.quick(1)
    @pytest.mark.parametrize("strategy", ["sns", SNS(rule="basic"), "sns_qp"], ids=["sns", "basic", "qp"])
    def test_a_level_that_cannot_be_met_does_not_disturb_the_higher_one(self, strategy):
        """The target of the elbow is out of its reach; the elbow is as close as the end effector's task allows."""
        q = np.array([0.5, 0.6, -0.4, -0.5, 0.7, 0.2])
        target = {"tip": planar_points(q)[-1], "elbow": 4 / 3 * planar_points(np.full(3, 0.3))[-1]}
        solution = self.solver(strategy, limits=False).solve(target, q0=q * 0.8)
        assert not solution.converged
        points = planar_points(solution.q)
        assert points[-1] == pytest.approx(target["tip"], abs=1e-6)
        nearest = minimize(
            lambda q: np.sum((planar_points(q)[2] - target["elbow"]) ** 2),
            solution.q,
            constraints={"type": "eq", "fun": lambda q: planar_points(q)[-1] - target["tip"]},
            options={"ftol": 1e-14},
        )
        assert np.linalg.norm(points[2] - target["elbow"]) == pytest.approx(math.sqrt(nearest.fun), abs=1e-4)


class TestSolving:
    STRATEGIES = ("sns", SNS(rule="basic"), "sns_qp")

    @pytest.mark.thinned
    @pytest.mark.parametrize("strategy", STRATEGIES, ids=["sns", "basic", "qp"])
    @pytest.mark.parametrize("target", [(2.0, 0.0), (2.0, 0.3), (3.9, 0.0)])
    @pytest.mark.parametrize("bend", [0.0, 1e-8, 1e-4])
    @pytest.mark.parametrize("turn", [0.0, 0.7])
    def test_a_straight_arm_pulled_inwards(self, strategy, target, bend, turn):
        """In any direction: what is a row of zeros along an axis is rounding elsewhere."""
        ik = arm_solver(strategy)
        cosine, sine = math.cos(turn), math.sin(turn)
        target = np.array([[cosine, -sine], [sine, cosine]]) @ target
        solution = ik.solve(target, q0=np.array([turn + bend, bend, bend, bend]))
        assert solution.converged
        assert planar_points(solution.q)[-1] == pytest.approx(target, abs=1e-6)

    @pytest.mark.quick(1)
    @pytest.mark.parametrize("strategy", STRATEGIES, ids=["sns", "basic", "qp"])
    def test_a_criterion_is_minimised_with_joints_at_their_limits(self, strategy):
        """Against SLSQP."""
        robot = planar(6, lower=-0.5, upper=0.5)
        wish = np.array([0.9, -0.6, 0.2, 0.4, -0.9, 0.1])
        q0 = np.array([0.1, 0.2, 0.3, -0.1, 0.2, -0.2])
        target = planar_points(q0)[-1] + np.array([-0.2, 0.1])
        ik = shared_solver(robot, jtik.FrameTask(), criteria=JointCentering(preferred=wish), strategy=strategy)
        solution = ik.solve(target, q0=q0)
        assert solution.converged
        oracle = minimize(
            lambda q: np.sum((q - wish) ** 2),
            q0,
            constraints={"type": "eq", "fun": lambda q: planar_points(q)[-1] - target},
            bounds=[(-0.5, 0.5)] * 6,
            options={"ftol": 1e-14},
        )
        assert (np.abs(np.abs(oracle.x) - 0.5) < 1e-9).sum() >= 2
        assert solution.q == pytest.approx(oracle.x, abs=1e-5)

    @pytest.mark.parametrize("strategy", ["sns", *slow("sns_qp")])
    def test_a_shortened_step_reaches_a_limit(self, strategy):
        """A joint that only halved its distance to the limit would never become active, and end every task there."""
        arm = planar(4, lower=-1.0, upper=1.0)
        ik = shared_solver(arm, jtik.FrameTask(), strategy=strategy)
        rng = np.random.default_rng(0)
        for factor in [1.5] * 12 + [10.0] * 12:
            q0, angle = rng.uniform(-1, 1, 4), rng.uniform(-math.pi, math.pi)
            solution = ik.solve(4 * factor * np.array([math.cos(angle), math.sin(angle)]), q0=q0)
            assert solution.status in (jtik.Status.LOCAL_MINIMUM, jtik.Status.LIMITS)

    @pytest.mark.slow
    def test_the_basic_rule_keeps_the_contract(self):
        check_strategy(SNS(rule="basic"), samples=1)


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("rule", "fast"),
        ("rounds", 0),
        ("gain", 0.0),
        ("gain", 1.5),
        ("damping", -1.0),
        ("q_limit", 0.0),
        ("secondary", ProjectedGradient(rule="sqrt")),
    ],
)
def test_options_are_checked(option, value):
    with pytest.raises(jtik.ArgumentError, match=option):
        SNS(**{option: value})


def test_the_function_and_the_strategy_have_the_same_defaults():
    theirs = inspect.signature(sns).parameters
    for name in ("rule", "rounds"):
        assert theirs[name].default == getattr(SNS(), name)
