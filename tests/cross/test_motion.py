"""What an arm feels in a control loop, for every strategy: quiet motion, limits solved instead of clipped.

Accelerations are second differences of q. Progress is compared with a linear program on the Jacobian in closed form.
The figures of all cases, and of more of them, are those of benchmarks/motion.py.

Its tests are thinned: ``--full`` runs all of them.
"""

from __future__ import annotations

import copy
import functools
import itertools

import numpy as np
import pytest
from scipy.optimize import least_squares, linprog
from scipy.spatial.transform import Rotation

import jtik
from jtik_formulations import JointCentering, ObstacleAvoidance

from ..conftest import families_first, large_ones_slow, planar, planar_jacobian, planar_points, shared_solver, slow

pytestmark = pytest.mark.thinned(together=True, times=2)

SLOW_TO_CONVERGE = ("transpose", "transpose_bb")
"""One step of these a sample is not enough to follow a path."""

JUMPING_WEIGHTS = ("weighted_least_norm",)
"""Their weights jump between two steps."""

FOLLOWING = [
    name for name in [*sorted(jtik.strategies), "hybrid+qp", "newton+second_order"] if name not in SLOW_TO_CONVERGE
]
COMPOSED = [
    "hybrid",
    "newton",
    "damped",
    "nakamura",
    "selectively_damped",
    "sns",
    "sns_qp",
    "task_priority",
]
"""Those that keep the direction of the task within limits; constant damping or a threshold would turn it."""

CLOSE = ["hybrid", "damped", "newton", "task_priority", "selectively_damped", "hybrid+qp", "lexicographic_qp", "mink"]
"""Those whose error is the smallest that limits of acceleration allow."""

CASES = [
    ("ur5e", "hybrid"),
    pytest.param("iiwa14", "hybrid", marks=pytest.mark.slow),
    pytest.param("ur5e", "weighted_qp", marks=pytest.mark.slow),
]

RMS = 0.6
"""Acceleration of the path itself under the shortest velocities, rms over the joints [rad/s^2]."""


def panda(strategy, **options):
    arm = jtik.Robot.builtin("panda")
    return shared_solver(arm, jtik.FrameTask(arm.tip, kind="pose"), strategy=strategy, **options)


def moved(start, displacements):
    """Poses displaced by (k, 3) [m]."""
    targets = np.tile(start, (len(displacements), 1, 1))
    targets[:, :3, 3] += displacements
    return targets


def stepped(ik, q, targets, dt):
    path = [q]
    for target in targets:
        path.append(ik.step(path[-1], target, dt=dt).q)
    return np.array(path)


def acceleration(path, dt):
    """Root mean square over joints and time."""
    return np.sqrt(np.mean(np.diff(path, 2, axis=0) ** 2)) / dt**2


def errors(ik, path, targets):
    tips = np.array([ik.robot.position(q) for q in path])
    return np.linalg.norm(tips - np.array([target[:3, 3] for target in targets]), axis=1)


def cosine(dt, duration=1.5):
    t = dt * np.arange(1, round(duration / dt) + 1)
    return np.outer(0.15 * (1 - np.cos(2 * np.pi * t / 3)), [0, 1, 0])


@pytest.mark.quick(2)
@pytest.mark.parametrize("strategy", families_first(FOLLOWING, large=False))
@pytest.mark.parametrize(("dt", "limit"), [(0.02, 10.0), pytest.param(0.002, 50.0, marks=pytest.mark.slow)])
def test_a_path_under_acceleration_limits_is_quiet(strategy, dt, limit):
    """In steps and by track; where one composition used to alternate between its limits."""
    ik = panda(strategy, limits=jtik.Limits(velocity=1.5, acceleration=limit))
    home = ik.robot.keyframes["home"]
    targets = moved(ik.robot.pose(home), cosine(dt))
    ways = {"step": stepped(ik, home, targets, dt), "track": np.vstack([home, ik.track(targets, q0=home, dt=dt).q])}
    for way, path in ways.items():
        if way == "step" and strategy in JUMPING_WEIGHTS:
            continue
        assert acceleration(path, dt) <= 1.2 * RMS, way
        assert errors(ik, path[1:], targets).max() <= 2e-5, way


@pytest.mark.quick(2)
@pytest.mark.parametrize("strategy", families_first([*FOLLOWING, "transpose"], large=False))
def test_outside_the_workspace_the_arm_does_not_shake(strategy):
    arm, dt = jtik.Robot.builtin("ur5e"), 0.02
    ik = shared_solver(arm, jtik.FrameTask(arm.tip, kind="position"), strategy=strategy)
    angles = np.concatenate([np.full(150, -0.4), np.linspace(-0.4, 0.4, 200)])
    targets = np.column_stack([1.05 * np.cos(angles), 1.05 * np.sin(angles), np.full(len(angles), 0.4)])
    path = stepped(ik, arm.keyframes["home"], targets, dt)[151:]
    velocity = np.diff(path, axis=0) / dt
    signs = np.sign(np.where(np.abs(velocity) > 1e-4, velocity, 0))
    changes = (signs[1:] * signs[:-1] < 0).any(axis=1).sum()
    assert changes < (60 if strategy == "transpose" else 5)
    away = np.linalg.norm([arm.position(q) - target for q, target in zip(path, targets[150:], strict=True)], axis=1)
    assert np.ptp(away[20:]) <= 1e-3


SMOOTH = [name for name in FOLLOWING if name not in JUMPING_WEIGHTS]


@pytest.mark.quick(1)
@pytest.mark.parametrize(
    ("strategy", "limit", "dt"),
    [
        *((name, None, 0.005) for name in ("hybrid", "newton", "task_priority")),
        *(pytest.param(name, 20.0, 0.002, marks=pytest.mark.slow) for name in SMOOTH),
    ],
)
def test_out_of_the_workspace_and_back(strategy, limit, dt):
    ik = panda(strategy, limits=jtik.Limits(velocity=2.0, acceleration=limit))
    home = ik.robot.keyframes["home"]
    t = dt * np.arange(1, round(4 / dt) + 1)
    out = np.concatenate([0.25 * (1 - np.cos(np.pi * t / 2)), np.zeros(round(1 / dt))])
    targets = moved(ik.robot.pose(home), np.outer(out, [1, 0, 0]))
    path = stepped(ik, home, targets, dt)[1:]
    away = errors(ik, path, targets)
    assert away.max() > 0.08  # it was out of reach
    assert away[-1] <= 1e-6
    assert away[len(t) - 1] <= (1e-5 if limit is None else 1e-3)


@pytest.mark.parametrize("strategy", ["hybrid", *slow("weighted_qp", "lexicographic_qp", "sns")])
@pytest.mark.parametrize(
    ("dt", "limit"),
    [(0.005, 20.0), *(pytest.param(*case, marks=pytest.mark.slow) for case in [(0.01, 10.0), (0.005, 50.0)])],
)
def test_with_limits_of_acceleration_no_arm_comes_back_on_the_other_side(strategy, limit, dt):
    """Where motion along the weak direction of a stretched arm carried the elbow to its limit, and it stayed there."""
    ik = panda(strategy, limits=jtik.Limits(velocity=2.0, acceleration=limit))
    home = ik.robot.keyframes["home"]
    t = dt * np.arange(1, round(4 / dt) + 1)
    out = np.concatenate([0.25 * (1 - np.cos(np.pi * t / 2)), np.zeros(round(0.5 / dt))])
    targets = moved(ik.robot.pose(home), np.outer(out, [1, 0, 0]))
    path = stepped(ik, home, targets, dt)[1:]
    away = errors(ik, path, targets)
    assert away[-1] <= 1e-6
    assert acceleration(path, dt) <= 5.0


@pytest.mark.parametrize("strategy", ["hybrid", *slow("weighted_qp", "lexicographic_qp", "sns", "task_priority")])
@pytest.mark.parametrize("dt", [0.01, *slow(0.002)])
def test_a_target_that_jumps_is_not_overshot(strategy, dt):
    """It used to be, by 76 to 115 mm."""
    ik = panda(strategy, limits=jtik.Limits(velocity=2.0, acceleration=10.0))
    home = ik.robot.keyframes["home"]
    start = ik.robot.position(home)
    targets = moved(ik.robot.pose(home), np.tile([0, 0.15, 0], (round(0.7 / dt), 1)))
    path = stepped(ik, home, targets, dt)[1:]
    assert max(ik.robot.position(q)[1] - start[1] for q in path) <= 0.15 + 1e-4
    assert errors(ik, path, targets)[round(0.45 / dt) :].max() <= 1e-3


QUICK = [pytest.param(0.002, limit, marks=pytest.mark.slow) for limit in (10.0, 50.0)]

SPEED = 0.1
"""Of the path that starts at speed [m/s]."""


@functools.cache
def joining(strategy, dt, limit):
    """The solver, its configurations and the targets, on a straight path of 1 s that starts at speed, from rest."""
    ik = panda(strategy, limits=jtik.Limits(velocity=1.5, acceleration=limit))
    q0 = np.array([2.258, -1.349, -1.256, -1.277, 1.660, 2.048, -1.089])
    t = dt * np.arange(1, round(1 / dt) + 1)
    start = ik.robot.pose(q0)
    targets = moved(start, np.outer(-SPEED * t, start[:3, 2]))
    return ik, stepped(ik, q0, targets, dt), targets


def started_at_speed(strategy, dt, limit):
    """Largest and root mean square error [m] and acceleration [rad/s^2]."""
    ik, path, targets = joining(strategy, dt, limit)
    away = errors(ik, path[1:], targets)
    return away.max(), np.sqrt(np.mean(away**2)), acceleration(path, dt)


def smallest_error_along(path, robot, direction, dt, limit):
    """The largest error [m] that is left where the end effector moves along ``direction`` alone, at best.

    A linear program over all steps together, with the Jacobian at the configurations of ``path``: joint displacements
    d_k and ways p_k with J_k d_k = p_k direction, |d_k - d_(k-1)| <= limit dt^2, and the smallest b that
    |k SPEED dt - (p_1 + ... + p_k)| <= b for all k.
    """
    count, n = len(path), path.shape[1]
    size = count * (n + 1) + 1
    equal, changes = np.zeros((6 * count, size)), np.zeros((n * count, size))
    for k, q in enumerate(path):
        equal[6 * k : 6 * k + 6, n * k : n * k + n] = robot.jacobian(q, robot.tip)
        equal[6 * k : 6 * k + 6, n * count + k] = -np.append(direction, np.zeros(3))
        changes[n * k : n * k + n, n * k : n * k + n] = np.eye(n)
        if k:
            changes[n * k : n * k + n, n * k - n : n * k] = -np.eye(n)
    made = np.zeros((count, size))
    made[:, n * count : -1] = np.tri(count)
    bound, wanted = np.eye(1, size, size - 1), SPEED * dt * np.arange(1, count + 1)
    found = linprog(
        bound[0],
        A_ub=np.vstack([changes, -changes, made - bound, -made - bound]),
        b_ub=np.concatenate([np.full(2 * n * count, limit * dt**2), wanted, -wanted]),
        A_eq=equal,
        b_eq=np.zeros(6 * count),
        bounds=[(None, None)] * (size - 1) + [(0, None)],
    )
    return found.fun


@pytest.mark.parametrize("strategy", ["sns", *slow("sns_qp")])
@pytest.mark.parametrize(("dt", "limit"), [(0.02, 10.0), *QUICK])
def test_where_the_direction_is_kept_a_path_that_starts_at_speed_is_joined_as_soon_as_it_can_be(strategy, dt, limit):
    """Their error is twice that of strategies that leave the direction; no rule that keeps it makes it smaller."""
    ik, path, targets = joining(strategy, dt, limit)
    count = 15 if dt == 0.02 else 40
    direction = (targets[1] - targets[0])[:3, 3] / (SPEED * dt)
    smallest = smallest_error_along(path[:count], ik.robot, direction, dt, limit)
    assert smallest > 1e-4
    assert started_at_speed(strategy, dt, limit)[0] <= 1.02 * smallest


@pytest.mark.parametrize("strategy", large_ones_slow(CLOSE))
@pytest.mark.parametrize(("dt", "limit"), [(0.02, 10.0), *QUICK])
def test_a_path_that_starts_at_speed_is_joined_soon_and_quietly(strategy, dt, limit):
    """Without turning back and forth before the path: that was 2.3 to 2.5 rad/s^2 at 2 ms."""
    largest, mean, quiet = started_at_speed(strategy, dt, limit)
    reference = started_at_speed("weighted_qp", dt, limit)
    assert largest <= 1.2 * reference[0]
    assert mean <= 1.2 * reference[1]
    assert quiet <= 1.2 * reference[2]
    assert quiet <= {(0.02, 10.0): 0.6, (0.002, 10.0): 1.8, (0.002, 50.0): 3.0}[dt, limit]


@functools.cache
def late(strategy, dt, criteria):
    """Largest and root mean square error [m], on a sine at 0.63 m/s from rest, with 10 rad/s^2."""
    limits = jtik.Limits(velocity=1.5, acceleration=10.0)
    ik = panda(strategy, limits=limits, criteria=0.1 * JointCentering() if criteria else None)
    t = dt * np.arange(1, round(0.4 / dt) + 1)
    targets = moved(ik.robot.pose(ik.robot.home), np.outer(0.2 * np.sin(np.pi * t), [0, 1, 0]))
    away = errors(ik, stepped(ik, ik.robot.home, targets, dt)[1:], targets)
    return away.max(), np.sqrt(np.mean(away**2))


@pytest.mark.parametrize("strategy", ["hybrid", *slow("sns", "damped", "newton", "task_priority", "sns_qp")])
@pytest.mark.parametrize("dt", [0.02, *slow(0.002)])
def test_an_arm_that_is_late_catches_up_beside_a_criterion_as_without(strategy, dt):
    """A joint at the limit of its braking is not active because the limit of its speeding up was: 1.4 times as late."""
    assert late(strategy, dt, True) == pytest.approx(late(strategy, dt, False), rel=0.02)


COMPROMISING = ("weighted_qp",)
"""Their rate in the null space is that of their weights."""

NULL_SPACE_FIRST = ("hybrid+qp",)
"""The others are tested slowly."""


@pytest.mark.quick(1)
@pytest.mark.parametrize(
    ("strategy", "limit"),
    [
        *((name, 10.0) for name in NULL_SPACE_FIRST),
        *(
            pytest.param(name, 10.0, marks=pytest.mark.slow)
            for name in FOLLOWING
            if name not in NULL_SPACE_FIRST + COMPROMISING
        ),
        ("hybrid", None),
    ],
)
def test_the_speed_in_the_null_space_does_not_depend_on_the_time_of_a_step(strategy, limit):
    ends, speeds = [], []
    built = panda(strategy, criteria=JointCentering(), limits=jtik.Limits(acceleration=limit), null_space_rate=3.0)
    for dt in (0.002, 0.02):
        ik = copy.copy(built)
        home = ik.robot.keyframes["home"] + [0.6, -0.2, -0.5, 0.3, 0.4, -0.2, 0.5]
        ik.parameters["joint_centering.preferred"] = ik.robot.keyframes["home"]
        path = stepped(ik, home, [ik.robot.pose(home)] * round(0.3 / dt), dt)
        speeds.append(np.abs(np.diff(path, axis=0)).max() / dt)
        ends.append(path[-1] - path[0])
    assert max(speeds) <= 1.0
    assert speeds[0] == pytest.approx(speeds[1], rel=0.1)
    assert np.linalg.norm(ends[0] - ends[1]) <= 0.15 * np.linalg.norm(ends[0])


def test_the_rate_is_that_of_the_decay():
    """Of the distance to the minimum of H on the self-motion, with a criterion that is its own quadratic model."""
    arm = planar(3)
    task = jtik.FrameTask("tip", kind="position", axes="y")
    ik = shared_solver(arm, task, criteria=JointCentering(), null_space_rate=4.0)
    q0 = np.array([0.02, -0.01, 0.03])
    start = np.abs(q0).max()
    path = stepped(ik, q0, [arm.position(q0)] * 50, 0.01)
    final = ik.solve(arm.position(q0), q0=q0).q
    distance = np.linalg.norm(path - final, axis=1)
    assert start > 0
    assert distance[-1] / distance[0] == pytest.approx(np.exp(-4.0 * 0.5), rel=0.05)


@pytest.mark.parametrize("strategy", large_ones_slow(["hybrid", "damped", "task_priority", "newton", "sns", "sns_qp"]))
def test_the_published_example_of_saturation(strategy):
    """Flacco, De Luca and Khatib (2012): four unit links; dq/dt by hand."""
    arm, dt = jtik.Robot.planar(4, velocity_limit=[2.0, 2.0, 4.0, 4.0]), 1e-6
    ik = shared_solver(arm, jtik.FrameTask("tip", kind="position"), strategy=strategy)
    q = np.deg2rad([90, -90, 90, -90])
    for share, expected in ((1.0, [2, -11 / 6, 11 / 6, -11 / 3]), (2.0, [2, -2, 26 / 11, -4])):
        ik.reset()
        step = ik.step(q, arm.position(q) + share * dt * np.array([-4.0, -1.5]), dt=dt)
        assert (step.q - q) / dt == pytest.approx(expected, abs=2e-4)


def largest_share(J, wanted, limit):
    """The largest s up to 1 with J v = s wanted within the limits."""
    n = J.shape[1]
    equal = np.column_stack([J, -wanted])
    bounds = [*((-bound, bound) for bound in limit), (0, 1)]
    return linprog([*[0.0] * n, -1.0], A_eq=equal, b_eq=np.zeros(len(wanted)), bounds=bounds).x[-1]


@pytest.mark.quick(2)
@pytest.mark.parametrize("strategy", large_ones_slow(COMPOSED))
@pytest.mark.parametrize("links", [4, *slow(7)])
def test_random_states_make_the_progress_that_is_feasible_in_the_direction_of_the_task(strategy, links, rng):
    dt, missed = 1e-5, 0
    limits = rng.uniform(0.3, 2, size=(2, links))
    for limit in limits:
        arm = jtik.Robot.planar(links, velocity_limit=limit)
        ik = shared_solver(arm, jtik.FrameTask("tip", kind="position"), strategy=strategy)
        for _ in range(25 if links == 4 else 150):
            q, wanted = rng.uniform(-2, 2, links), rng.normal(size=2) * rng.uniform(0.5, 4)
            ik.reset()
            made = planar_points(ik.step(q, arm.position(q) + dt * wanted, dt=dt).q)[-1] - planar_points(q)[-1]
            share = made @ wanted / (wanted @ wanted) / dt
            direction = np.linalg.norm(made / dt - share * wanted)
            feasible = largest_share(planar_jacobian(q), wanted, limit)
            missed += share < 0.99 * feasible or direction > 2e-3 * np.linalg.norm(wanted)
    assert missed <= 1


@pytest.mark.parametrize("arm", ["panda", "ur5e"])
def test_newton_follows_a_path_from_the_zero_pose(arm):
    robot, dt = jtik.Robot.builtin(arm), 0.02
    ik = shared_solver(robot, jtik.FrameTask(robot.tip, kind="position"), strategy="newton")
    q = robot.configuration(np.clip(np.zeros(robot.nq), robot.lower, robot.upper))[robot.kept_indices]
    q = q[: ik.robot.nq]
    start, rng = ik.robot.position(q), np.random.default_rng(2)
    end = ik.robot.position(ik.robot.random_configuration(rng))
    targets = [start + share * (end - start) for share in np.linspace(0, 1, 200)] + [end] * 50
    path = stepped(ik, q, targets, dt)
    assert np.linalg.norm(ik.robot.position(path[-1]) - end) <= 1e-5


@pytest.mark.parametrize(("a", "b"), [("hybrid", "newton"), ("newton", "damped")])
def test_on_a_path_that_is_followed_they_are_the_same(a, b):
    """Damping of a timed step vanishes with the error that the step before has left."""
    paths = []
    for name in (a, b):
        ik = panda(name, limits=jtik.Limits(velocity=1.5, acceleration=10.0))
        home = ik.robot.keyframes["home"]
        paths.append(stepped(ik, home, moved(ik.robot.pose(home), cosine(0.02)), 0.02))
    assert np.abs(paths[0] - paths[1]).max() <= 1e-5


def test_a_criterion_does_not_take_a_path_off_its_target():
    """At a constant target that is reached: the step in the null space leaves it to second order."""
    robot = jtik.Robot.vehicle(3)
    ik = shared_solver(robot, jtik.FrameTask(robot.tip, kind="position"), criteria=JointCentering())
    q0 = np.concatenate([[0.5, -0.4], [0.3, 0.9, -0.6, 0.4]])[: robot.nq]
    path = ik.track([robot.position(q0)] * 30, q0=q0, dt=0.05)
    assert path.converged
    assert path.position_error.max() <= 1e-6
    assert np.abs(path.q[-1] - q0).max() > 0.1


@pytest.mark.parametrize(("arm", "strategy"), CASES)
@pytest.mark.parametrize("criteria", [None, JointCentering()])
def test_far_out_of_reach_an_arm_with_acceleration_limits_comes_to_rest(arm, strategy, criteria):
    robot, dt = jtik.Robot.builtin(arm), 0.01
    ik = shared_solver(
        robot,
        jtik.FrameTask(robot.tip, kind="position"),
        strategy=strategy,
        criteria=criteria,
        limits=jtik.Limits(velocity=1.5, acceleration=20.0),
    )
    q = 0.3 * np.ones(ik.robot.nq)
    path = stepped(ik, np.clip(q, ik.robot.lower, ik.robot.upper), [[2.0, 1.5, 1.5]] * 800, dt)
    assert acceleration(path[-200:], dt) <= 0.1


def test_a_saddle_is_left_under_acceleration_limits():
    """A Panda at a stretched posture with joints at their limits, from which V falls to second order only."""
    arm, dt = jtik.Robot.builtin("panda"), 0.002
    limits = jtik.Limits(velocity=1.5, acceleration=10.0)
    ik = shared_solver(arm, jtik.FrameTask("tip", kind="position"), limits=limits)
    target = ik.robot.position(ik.robot.keyframes["home"])
    stuck = np.array([0.0, 1.291, 0.0, -0.0698, 0.0, 3.7525, 0.785])
    path = stepped(ik, stuck, [target] * 3000, dt)
    assert np.linalg.norm(ik.robot.position(path[-1]) - target) <= 1e-6


@pytest.mark.parametrize("at_once", [False, True])
@pytest.mark.parametrize("dt", [None, 0.01])
@pytest.mark.parametrize("strategy", ["hybrid+qp", *slow("weighted_qp", "lexicographic_qp")])
def test_an_arm_at_its_target_avoids_a_moving_obstacle(strategy, dt, at_once):
    """After many steps at rest, in which nothing was to be done; also one that is too close before the arm can move."""
    arm, safe, radius = planar(4), 0.1, 0.2
    field = ObstacleAvoidance([jtik.Circle((6.0, 6.0), radius)], bodies="links")
    clearance = jtik.Clearance(field, safe=safe)
    ik = shared_solver(arm, jtik.FrameTask("tip"), strategy=strategy, clearances=clearance)
    q = np.array([0.3, 0.5, -0.6, 0.4])
    target = arm.position(q)
    for _ in range(300):
        q = ik.step(q, target, dt=dt).q
    for height in [*([] if at_once else np.linspace(1.0, 0.23, 200)), *[0.23] * 150]:
        center = target + np.array([0.0, height])
        ik.parameters["clearance.centers"] = [center]
        q = ik.step(q, target, dt=dt).q
    distances = []
    for a, b in itertools.pairwise(planar_points(q)):
        along = np.clip((center - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
        distances.append(np.linalg.norm(center - a - along * (b - a)) - radius)
    assert min(distances) >= safe - 1e-9


STAGNANT = [name for name in jtik.strategies if jtik.strategies[name]().damps_stagnation()]
"""Strategies that a target out of reach used to keep in motion: their steps are longer than their model is right."""

RESTS = [*STAGNANT, "hybrid", "damped", "weighted_qp", "newton+qp"]


def stretched(robot):
    """The largest distance of the tip from the base of a planar arm."""
    return float(np.linalg.norm(robot.position(np.zeros(robot.n))))


@pytest.mark.parametrize("factor", [1.3, *slow(1.02, 3.0)])
@pytest.mark.parametrize("kind", ["position", "pose"])
@pytest.mark.parametrize("strategy", [*families_first(RESTS, large=False)])
def test_at_a_fixed_target_out_of_reach_every_step_comes_to_rest_at_the_closest_posture(strategy, kind, factor):
    """Without a time as well, where `newton` moved by 0.006 rad a step for ever, up to a third of the reach away."""
    arm = planar(3)
    ik = shared_solver(arm, jtik.FrameTask("tip", kind=kind), strategy=strategy)
    goal = np.eye(3)
    goal[:2, 2] = factor * stretched(arm) * np.array([0.8, 0.6])
    target = goal[:2, 2] if kind == "position" else goal
    ends = []
    for dt in (None, 0.02):
        ik.reset()
        path = stepped(ik, np.array([0.4, 0.1, -0.1]), [target] * 500, dt)
        assert np.abs(np.diff(path[-50:], axis=0)).max() <= 1e-6, dt
        ends.append(np.linalg.norm(arm.position(path[-1]) - goal[:2, 2]))
    assert ends[0] == pytest.approx(ends[1], abs=1e-4 * factor)
    if kind == "position":
        assert ends[0] == pytest.approx((factor - 1) * stretched(arm), abs=1e-4 * factor)


@pytest.mark.parametrize("strategy", large_ones_slow(["mink", "weighted_qp"]))
def test_a_long_arm_comes_to_rest_out_of_reach_too(strategy):
    """Where every step is taken, the damping has to exceed the curvature of ten links: 0.1 rad a step for ever."""
    arm = planar(10)
    ik = shared_solver(arm, jtik.FrameTask("tip", kind="position"), strategy=strategy)
    path = stepped(ik, np.linspace(0.4, 0.2, 10), [30 * np.array([0.8, 0.6])] * 700, 0.02)
    assert np.abs(np.diff(path[-50:], axis=0)).max() <= 1e-6


@pytest.mark.parametrize("strategy", large_ones_slow(STAGNANT))
def test_a_step_is_undamped_again_as_soon_as_its_target_moves_or_is_in_reach(strategy):
    """After a long rest a target inside is reached in about as many steps as by a solver that begins there."""
    arm = planar(4)
    ik = shared_solver(arm, jtik.FrameTask("tip", kind="position"), strategy=strategy)
    inside, needed = np.array([1.0, 1.5]), []
    for before in ([np.array([4.0, 3.0])] * 200, []):
        ik.reset()
        stepped(ik, np.array([0.4, 0.3, -0.2, 0.5]), before, None)
        path = stepped(ik, [0.5, 0.6, -0.3, 0.4], [inside] * 60, None)
        away = np.array([np.linalg.norm(arm.position(each) - inside) for each in path])
        assert away[-1] <= 1e-6
        needed.append(int(np.argmax(away <= 1e-6)))
    assert needed[0] <= needed[1] + 10


def test_where_a_limit_holds_an_arm_that_comes_back_a_solve_says_so_and_finds_another_posture():
    """Drawn out with the elbow between its stretched pose and its limit: a true local minimum, by SciPy as well."""
    dt, rng = 0.01, np.random.default_rng(13)
    ik = panda("hybrid", limits=jtik.Limits(velocity=2.0))
    arm = ik.robot
    rng.uniform(arm.lower, arm.upper)
    q = arm.lower + (0.1 + 0.8 * rng.uniform(size=7)) * (arm.upper - arm.lower)
    start, direction = arm.pose(q), rng.normal(size=3)
    direction /= np.linalg.norm(direction)
    wrist = start[:3, 3] - [0, 0, 0.333]
    along = wrist @ direction
    length = np.sqrt(along**2 - wrist @ wrist + 1.0) - along  # to 1 m from the shoulder
    t = dt * np.arange(1, round(4 / dt) + 1)
    share = np.concatenate([(1 - np.cos(np.pi * t / 2)) / 2, np.zeros(100)])
    targets = moved(start, length * np.outer(share, direction))
    path = stepped(ik, q, targets, dt)
    held = path[-1]
    assert errors(ik, path[1:], targets)[-1] > 0.1
    solution = ik.solve(start, q0=held)
    assert solution.status is jtik.Status.LIMITS
    assert "joint4" in " ".join(solution.active_limits)
    rotation = Rotation.from_matrix(start[:3, :3])

    def residual(q):
        pose = arm.pose(q)
        turn = (Rotation.from_matrix(pose[:3, :3]) * rotation.inv()).as_rotvec()
        return np.concatenate([pose[:3, 3] - start[:3, 3], turn])

    nearby = np.clip(held + 1e-3, arm.lower + 1e-9, arm.upper - 1e-9)
    found = least_squares(residual, nearby, bounds=(arm.lower, arm.upper), max_nfev=30)
    assert np.linalg.norm(found.fun) >= np.linalg.norm(residual(held)) - 1e-3
    assert ik.solve(start, q0=held, restarts=20).status is jtik.Status.CONVERGED
