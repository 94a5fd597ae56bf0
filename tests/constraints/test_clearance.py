"""Clearances as hard constraints: kept along every accepted step, live, and named where they block a solve.

Its tests are thinned: ``--full`` runs all of them.
"""

from __future__ import annotations

import functools
import math
import pickle
import re

import numpy as np
import pytest

import jtik
from jtik_formulations import JointCentering, KhatibPotential, ObstacleAvoidance, ObstacleBarrier, SelfCollision

from .._step.conftest import problem_of
from ..conftest import planar, planar_points, shared_solver, slow

pytestmark = pytest.mark.thinned

FIELD = [jtik.Circle((2.0, 1.2), 0.4), jtik.Circle((3.2, -0.8), 0.5), jtik.Circle((1.0, -1.5), 0.4)]
SAFE = 0.05
ROUNDING = 1e-9


def gaps(q, field=FIELD):
    """Distance of each link to each circle, by the closest point of its segment."""
    points = np.vstack([[0.0, 0.0], planar_points(q)])
    a, along = points[:-1, None], np.diff(points, axis=0)[:, None]
    centers, radii = np.array([c.center for c in field]), np.array([c.radius for c in field])
    share = np.clip(((centers - a) * along).sum(-1) / (along**2).sum(-1), 0, 1)
    return np.linalg.norm(a + share[..., None] * along - centers, axis=-1) - radii


def swept(trace):
    """The smallest gap along the straight lines in joint space between the iterates of a trace."""
    least = math.inf
    for start, end in zip(trace.q[:-1], trace.q[1:], strict=True):
        if not np.array_equal(start, end):
            least = min(least, *[gaps(start + share * (end - start)).min() for share in np.linspace(0, 1, 15)])
    return least


def solver(robot, strategy="hybrid+qp", criteria=None, bodies="links", field=FIELD, **options):
    clearance = jtik.Clearance(ObstacleAvoidance(field, bodies=bodies), safe=SAFE, **options)
    return shared_solver(robot, jtik.FrameTask(), criteria=criteria, strategy=strategy, clearances=clearance)


@pytest.fixture(scope="module")
def problems():
    """Starts and targets of a five-link arm, both clear."""
    rng, found = np.random.default_rng(3), []
    while len(found) < 5:
        q, p = rng.uniform(-1.5, 1.5, (2, 5))
        if min(gaps(q).min(), gaps(p).min()) > SAFE + 0.02:
            found.append((q, planar_points(p)[-1]))
    return found


@pytest.mark.quick(1, slow=2)
@pytest.mark.parametrize("strategy", ["hybrid+qp", *slow("newton+qp", "transpose+qp", "damped+qp")])
@pytest.mark.parametrize("criteria", [JointCentering(), *slow(None)], ids=["centring", "alone"])
def test_no_accepted_step_is_closer_than_safe(strategy, criteria, problems):
    ik, plain = (
        solver(planar(5), strategy, criteria),
        solver(planar(5), strategy, criteria, field=[jtik.Circle((90.0, 0.0))]),
    )
    through, reached = 0, 0
    for q, target in problems:
        solution = ik.solve(target, q0=q, max_iterations=250, trace=True)
        assert swept(solution.trace) >= SAFE - ROUNDING
        assert gaps(solution.q).min() >= SAFE - ROUNDING
        reached += solution.position_error <= 1e-6
        through += swept(plain.solve(target, q0=q, max_iterations=250, trace=True).trace) < SAFE
    assert through >= 2  # without, several go through: the problems ask for it
    assert reached >= 2


def test_clearances_hold_between_the_ends_of_a_step():
    """A thin obstacle between the ends of a long step: both ends alone are clear of it."""
    ik = shared_solver(
        planar(1),
        jtik.FrameTask(),
        strategy="hybrid+qp",
        clearances=jtik.Clearance(ObstacleAvoidance(jtik.Point((0.98, 0.2)), bodies="links"), safe=0.01),
    )
    solution = ik.solve([math.cos(0.5), math.sin(0.5)], q0=[0.0], trace=True)
    assert solution.status is jtik.Status.BLOCKED
    assert solution.q[0] < math.atan2(0.2, 0.98)
    assert gaps(solution.q, [jtik.Circle((0.98, 0.2))]).min() >= 0.01 - ROUNDING


class TenLinks:
    """A solver for ten links and four circles that are live parameters, and scenes for it."""

    def __init__(self, strategy, criteria, bodies):
        field = [jtik.Circle((30.0 + i, 0.0), 0.5) for i in range(4)]
        self.ik = solver(planar(10), strategy, criteria, bodies, field)
        self.bodies = bodies

    def solve(self, scene, **options):
        q, target, self.centers, self.radii = scene
        self.ik.parameters["clearance.centers"] = self.centers
        self.ik.parameters["clearance.radii"] = self.radii
        return self.ik.solve(target, q0=q, trace=True, **options)

    def gaps(self, q):
        """Of each body to each circle."""
        return gaps_of(q, self.centers, self.radii, self.bodies)

    def ways(self, trace):
        """Gaps along the straight joint-space ways of the accepted steps, (steps, places, bodies, circles)."""
        q = np.unwrap(trace.q, axis=0)  # at its end a solve turns joints back by whole turns
        start, end = q[:-1, None], q[1:, None]
        moved = (start != end).any(axis=(1, 2))
        return self.gaps((start + np.linspace(0, 1, 9)[:, None] * (end - start))[moved])


ten_links = functools.cache(TenLinks)


def gaps_of(q, centers, radii, bodies):
    """As `gaps`, of joints or links, and for any number of configurations (..., n)."""
    angles = np.cumsum(q, axis=-1)
    points = np.stack([np.cumsum(np.cos(angles), -1), np.cumsum(np.sin(angles), -1)], -1)
    if bodies == "joints":
        return np.linalg.norm(points[..., None, :] - centers, axis=-1) - radii
    a = np.concatenate([0 * points[..., :1, :], points[..., :-1, :]], axis=-2)[..., None, :]
    along = points[..., None, :] - a
    share = np.clip(((centers - a) * along).sum(-1) / (along**2).sum(-1), 0, 1)
    return np.linalg.norm(a + share[..., None] * along - centers, axis=-1) - radii


def scenes(count, bodies, least, most=math.inf, seed=5):
    """(q, target, centres, radii): the smallest gap of the start is between the bounds, a posture on target clear."""
    rng, found = np.random.default_rng(seed), []
    while len(found) < count:
        q, p = rng.uniform(-0.8, 0.8, (2, 10))
        centers, radii = rng.uniform(-6, 6, (4, 2)), rng.uniform(0.3, 0.8, 4)
        q[0], p[0] = 3 * q[0], 3 * p[0]
        there = gaps_of(p, centers, radii, bodies).min() > SAFE + 0.03
        if there and least < gaps_of(q, centers, radii, bodies).min() < most:
            found.append((q, planar_points(p)[-1], centers, radii))
    return found


@pytest.mark.quick(1)
@pytest.mark.parametrize(
    ("bodies", "criteria"), [("links", None), pytest.param("joints", JointCentering(), marks=pytest.mark.slow)], ids=str
)
@pytest.mark.parametrize("strategy", ["weighted_qp", "lexicographic_qp"])
def test_strategies_of_one_quadratic_program_keep_clearances(strategy, criteria, bodies):
    ten, reached = ten_links(strategy, criteria, bodies), 0
    for scene in scenes(8, bodies, SAFE + 0.02):
        solution = ten.solve(scene, max_iterations=100)
        assert solution.status is not jtik.Status.UNSOLVED
        assert ten.ways(solution.trace).min(initial=1.0) >= SAFE - ROUNDING
        reached += solution.position_error < 0.01
    assert reached >= 2


def test_two_levels_keep_clearances_and_report_the_level_not_met():
    """The end effector can reach its target, the elbow cannot: a circle is at it."""
    arm, q = planar(5), np.array([0.4, 0.3, -0.5, -0.4, 0.3])
    points = planar_points(q)
    tasks = [
        jtik.FrameTask("tip", name="tip", priority=0),
        jtik.FrameTask("link3", name="elbow", priority=1),
    ]
    centre = points[1] + [0.0, 0.6]
    circle = jtik.Clearance(ObstacleAvoidance(jtik.Circle(centre, 0.5), bodies="joints"), safe=SAFE)
    ik = shared_solver(arm, tasks, strategy="lexicographic_qp", clearances=circle)
    solution = ik.solve({"tip": points[-1], "elbow": centre}, q0=q, trace=True)
    assert min(gaps_of(at, centre, 0.5, "joints").min() for at in solution.trace.q) >= SAFE - ROUNDING
    assert np.linalg.norm(planar_points(solution.q)[-1] - points[-1]) <= 1e-4
    missed = {each.name: each for each in solution.relaxed}
    assert set(missed) == {"level 1"}
    assert missed["level 1"].amount == pytest.approx(solution.position_error, rel=0.1)


RECOVERING = ["hybrid+qp", "newton+qp", "weighted_qp", "lexicographic_qp"]


@pytest.mark.quick(1)
@pytest.mark.parametrize("strategy", ["hybrid+qp", "weighted_qp", *slow("newton+qp", "lexicographic_qp")])
def test_a_start_too_close_is_restored_and_no_pair_comes_closer(strategy):
    ten = ten_links(strategy, None, "links")
    for scene in scenes(8, "links", 0.0, SAFE):
        solution = ten.solve(scene, max_iterations=100)
        assert solution.status is not jtik.Status.UNSOLVED
        assert ten.gaps(solution.q).min() >= SAFE - ROUNDING
        ways = ten.ways(solution.trace)
        floor = np.minimum(ways[:, :1], SAFE)  # of each pair: what is too near comes no nearer, nothing else gets so
        assert (ways - floor).min() >= -1e-8


@pytest.mark.quick(2)
@pytest.mark.parametrize("strategy", RECOVERING)
def test_restoration_at_the_target_does_not_lose_it(strategy):
    """On target, and too close: the null space restores the clearance before the solve converges."""
    arm, q = planar(6), np.array([0.4, 0.3, -0.5, -0.4, 0.3, 0.2])
    points = planar_points(q)
    near = jtik.Circle(points[2] + [0.0, 0.32], 0.3)
    ik = solver(arm, strategy, bodies="joints", field=[near])
    solution = ik.solve(points[-1], q0=q)
    assert solution.status is jtik.Status.CONVERGED
    assert solution.iterations > 0
    assert np.linalg.norm(planar_points(solution.q) - near.center, axis=1).min() >= 0.3 + SAFE - 2e-6
    reached = ik.solve(points[-1], q0=q, until="reached")
    assert reached.iterations == 0


def test_the_speed_of_restoration_is_that_of_the_barrier():
    """One joint, alone with one circle: half of what lacks of safe + margin, in a step that nothing else hinders."""
    arm, q = planar(3), np.array([0.4, 0.5, 0.3])
    points = planar_points(q)
    ik = solver(arm, "weighted_qp", bodies="joints", field=[jtik.Circle(points[0] + [0.0, 0.32], 0.3)])
    program = ik.build(q, points[-1])
    lacking = SAFE + 0.01 - 0.02
    demanded = -program.h[program.h < 0]
    assert demanded == pytest.approx([0.5 * lacking], rel=1e-3)


@pytest.mark.quick(2)
@pytest.mark.parametrize(
    ("strategy", "criteria"),
    [
        pytest.param("hybrid+qp", None, id="hybrid+qp-alone"),
        pytest.param("transpose+qp", JointCentering(), id="transpose+qp-centring"),
        pytest.param("weighted_qp", None, id="weighted_qp-alone"),
        pytest.param("lexicographic_qp", JointCentering(), id="lexicographic_qp-centring"),
    ],
)
def test_contradictory_clearances_have_a_status_and_are_named(strategy, criteria):
    """A joint between two circles that are too close to each other: both clearances cannot hold."""
    arm, q = planar(5), np.array([0.3, -0.5, 0.4, 0.6, -0.3])
    points = planar_points(q)
    field = [jtik.Circle(points[1] + [0.0, side * 0.43], 0.4) for side in (-1, 1)]
    ik = solver(arm, strategy, criteria, "joints", field)
    solution = ik.solve(points[-1] + [0.05, 0.1], q0=q, max_iterations=300)
    assert solution.status in (jtik.Status.BLOCKED, jtik.Status.ITERATION_LIMIT)
    relaxed = {each.name: each for each in solution.relaxed}
    for i, circle in enumerate(field):
        gap = np.linalg.norm(planar_points(solution.q)[1] - circle.center) - 0.4
        assert gap >= 0.03 - ROUNDING
        entry = relaxed[f"clearance: link3 to obstacle {i}"]
        assert (entry.amount, entry.unit) == (pytest.approx(SAFE + 0.01 - gap), "m")
    assert "relaxed" in repr(solution)


def test_the_share_of_the_task_step_is_reported(problems):
    ik = shared_solver(
        planar(1),
        jtik.FrameTask(),
        strategy="hybrid+qp",
        clearances=jtik.Clearance(ObstacleAvoidance(jtik.Point((0.98, 0.2)), bodies="links"), safe=0.01),
    )
    solution = ik.solve([math.cos(0.5), math.sin(0.5)], q0=[0.0], trace=True)
    [entry] = solution.relaxed
    assert (entry.name, entry.unit) == ("task step", "share")
    assert entry.amount > 0.9
    assert str(entry) == "task step by 100 %"
    share = solution.trace.task_share[: np.argmax(solution.trace.task_share < 1e-6)]  # before it is a rounding error
    assert share[0] > 0.1 > share[-1]
    assert (np.diff(share) < 0).all()
    assert solution.trace.too_near.max() < 0.01
    assert pickle.loads(pickle.dumps(solution)).relaxed == solution.relaxed


def test_nothing_is_relaxed_where_all_constraints_can_hold(problems):
    q, target = problems[0]
    ik = solver(planar(5), field=[jtik.Circle((90.0, 0.0))])
    solution = ik.solve(target, q0=q)
    assert solution.relaxed == ()
    assert "relaxed" not in repr(solution)
    plain = shared_solver(planar(5), jtik.FrameTask()).solve(target, q0=q)
    assert plain.relaxed == ()


def test_the_former_name_of_restore_warns():
    with pytest.warns(DeprecationWarning, match=re.escape("Clearance(recover=) is now called restore=")):
        kept = jtik.Clearance(ObstacleAvoidance([jtik.Circle((2, 2), 0.1)]), recover=False)
    assert kept.restore is False


def test_without_restoration_a_distance_does_not_decrease(problems):
    q, target = problems[0]
    near = jtik.Circle(planar_points(q)[2] + (0.0, 0.31), 0.3)
    ik = solver(planar(5), field=[near], restore=False)
    assert "restoration" not in [call.call.name for call in ik._engine.runners.solve.fused.parts.preparations]
    smallest = [gaps(p, [near]).min() for p in ik.solve(target, q0=q, trace=True, max_iterations=200).trace.q]
    assert min(smallest) >= gaps(q, [near]).min() - 1e-6


@pytest.mark.quick(1)
@pytest.mark.parametrize("backend", ["osqp", jtik.qp.QPSolversBackend("daqp"), jtik.qp.PersistentOSQP()], ids=str)
def test_any_back_end_restores_clearances(backend):
    arm, q = planar(5), np.array([0.4, 0.3, -0.5, -0.4, 0.3])
    points = planar_points(q)
    near = jtik.Circle(points[2] + [0.0, 0.32], 0.3)
    clearance = jtik.Clearance(ObstacleAvoidance(near, bodies="joints"), safe=SAFE)
    ik = shared_solver(arm, jtik.FrameTask(), strategy="newton+qp", clearances=clearance, solver=backend)
    solution = ik.solve(points[-1] - [0.3, 0.3], q0=q, max_iterations=200)
    assert np.linalg.norm(planar_points(solution.q) - near.center, axis=1).min() >= 0.3 + SAFE - 1e-3


def test_a_start_too_close_comes_no_closer(problems):
    q, target = problems[0]
    near = jtik.Circle(planar_points(q)[2] + (0.0, 0.31), 0.3)  # 0.01 off a joint, or less off a link
    start = gaps(q, [near]).min()
    assert start < SAFE
    ik = solver(planar(5), field=[near])
    trace = ik.solve(target, q0=q, trace=True, max_iterations=200).trace
    smallest = [gaps(p, [near]).min() for p in trace.q]
    assert min(smallest) >= start - 1e-6


def test_live_parameters(problems):
    q, target = problems[0]
    ik = solver(planar(5))
    ik.parameters["clearance.centers"] = np.full((3, 2), 50.0)
    far = ik.solve(target, q0=q)
    assert far.position_error <= 1e-6
    ik.parameters["clearance.centers"] = [circle.center for circle in FIELD]
    ik.parameters["clearance.safe"] = 0.09
    assert gaps(ik.solve(target, q0=q).q).min() >= min(0.09, gaps(q).min()) - ROUNDING


def test_the_barrier_form_keeps_clear_from_any_distance(problems):
    q, target = problems[1]
    trace = solver(planar(5), influence=math.inf).solve(target, q0=q, max_iterations=300, trace=True).trace
    assert swept(trace) >= SAFE - ROUNDING


@pytest.mark.slow
def test_limits_and_clearances_together(problems):
    robot = planar(5, lower=-1.5, upper=1.5)
    ik = solver(robot, criteria=JointCentering())
    for q, target in problems[:4]:
        trace = ik.solve(target, q0=q, max_iterations=300, trace=True).trace
        assert swept(trace) >= SAFE - ROUNDING
        assert np.abs(trace.q).max() <= 1.5


def test_rows_name_what_they_are(problems):
    q, target = problems[0]
    ik = solver(planar(5))
    problem = ik.build(q, target)
    assert problem.P.shape == (5, 5)
    room = ik.build(q, target, qp="restoration")
    assert room.P.shape == (5, 5)


class TestInvalidInput:
    @pytest.mark.parametrize("strategy", ["hybrid", "sns_qp", "mink", "newton+second_order"])
    def test_a_strategy_without_rows_for_them(self, strategy):
        with pytest.raises(jtik.ArgumentError, match="clearances.*'lexicographic_qp', 'weighted_qp'.*'hybrid\\+qp'"):
            solver(planar(3), strategy)

    def test_two_of_one_name(self):
        one = jtik.Clearance(ObstacleAvoidance(FIELD))
        with pytest.raises(jtik.ArgumentError, match="name"):
            jtik.InverseKinematics(planar(3), jtik.FrameTask(), strategy="hybrid+qp", clearances=[one, one])

    def test_an_argument_that_is_not_a_clearance(self):
        with pytest.raises(jtik.ArgumentError, match="clearances"):
            jtik.InverseKinematics(planar(3), jtik.FrameTask(), strategy="hybrid+qp", clearances=[3.0])

    @pytest.mark.parametrize(
        ("options", "named"),
        [
            ({"safe": -0.1}, "safe"),
            ({"safe": np.nan}, "safe"),
            ({"influence": 0.01}, "influence"),
            ({"gain": 0.0}, "gain"),
            ({"gain": 1.5}, "gain"),
            ({"margin": 0.0}, "margin"),
            ({"restore": "soon"}, "restore"),
        ],
    )
    def test_values(self, options, named):
        with pytest.raises(jtik.ArgumentError, match=named):
            jtik.Clearance(ObstacleAvoidance(FIELD), **options)

    def test_a_measure_without_distances(self):
        with pytest.raises(jtik.ArgumentError, match="measure"):
            jtik.Clearance(JointCentering())


@pytest.mark.parametrize(
    "measure",
    [
        KhatibPotential([jtik.Circle((2, 1), 0.2)], influence=0.6, gain=7.0),
        ObstacleBarrier([jtik.Circle((2, 1), 0.2)], influence=0.6),
        SelfCollision(radius=0.02, influence=0.6),
    ],
)
def test_influence_and_gain_of_the_measure_are_not_those_of_the_clearance(measure):
    """The criterion's own influence and gain shape its H; the clearance has its own."""
    clearance = jtik.Clearance(measure, influence=0.25)
    ik = shared_solver(planar(4), jtik.FrameTask(kind="position"), clearances=clearance, strategy="hybrid+qp")
    assert ik.parameters["clearance.influence"] == 0.25
    assert "clearance.gain" not in ik.parameters
    problem = problem_of(planar(4), clearances=[clearance])
    figures = problem.measured.clearance(np.full(4, 0.3), problem.terms.parameters.memory)[2].full()
    assert set(figures[:, 2]) == {0.25}
    assert set(figures[:, 3]) == {0.5}


def test_a_measure_whose_own_distances_depend_on_such_a_name_keeps_its_value():
    class Grown(ObstacleAvoidance):
        def parameters(self, robot):
            return {**super().parameters(robot), "safe": 0.125}

        def distances(self, kinematics, parameters):
            return [[d - parameters["safe"] for d in body] for body in super().distances(kinematics, parameters)]

    obstacle, q = jtik.Circle((2, 1), 0.2), np.full(4, 0.3)
    found = []
    for measure in (ObstacleAvoidance([obstacle]), Grown([obstacle], name="grown")):
        problem = problem_of(planar(4), clearances=[jtik.Clearance(measure, safe=0.03)])
        found.append(problem.measured.clearance(q, problem.terms.parameters.memory)[0].full())
    assert found[0] - found[1] == pytest.approx(0.125)
