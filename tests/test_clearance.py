"""Clearances as hard constraints: kept all along every accepted step, live, and told of when they hold a solve."""

from __future__ import annotations

import math

import numpy as np
import pytest

import jtik
from jtik.clearance import travels
from jtik_formulations import JointCentering, ObstacleAvoidance

from .conftest import dh_arm, planar, planar_points

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
    """The least gap along the straight joint-space way between the iterates of a trace."""
    least = math.inf
    for start, end in zip(trace.q[:-1], trace.q[1:], strict=True):
        if not np.array_equal(start, end):
            least = min(least, *[gaps(start + share * (end - start)).min() for share in np.linspace(0, 1, 15)])
    return least


def solver(robot, strategy="hybrid+qp", criteria=None, bodies="links", field=FIELD, **options):
    clearance = jtik.Clearance(ObstacleAvoidance(field, bodies=bodies), safe=SAFE, **options)
    return jtik.InverseKinematics(robot, jtik.FrameTask(), criteria=criteria, strategy=strategy, clearances=clearance)


@pytest.fixture(scope="module")
def problems():
    """Starts and targets of a five-link arm, both clear."""
    rng, found = np.random.default_rng(3), []
    while len(found) < 5:
        q, p = rng.uniform(-1.5, 1.5, (2, 5))
        if min(gaps(q).min(), gaps(p).min()) > SAFE + 0.02:
            found.append((q, planar_points(p)[-1]))
    return found


@pytest.mark.parametrize("strategy", ["hybrid+qp", "newton+qp", "transpose+qp", "damped+qp"])
@pytest.mark.parametrize("criteria", [None, JointCentering()], ids=["alone", "centring"])
def test_no_accepted_step_comes_nearer_than_safe(strategy, criteria, problems):
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


def test_the_way_is_proven_between_samples_too():
    """A thin obstacle that lies between the ends of a long step: the ends alone would say it is clear."""
    ik = jtik.InverseKinematics(
        planar(1),
        jtik.FrameTask(),
        strategy="hybrid+qp",
        clearances=jtik.Clearance(ObstacleAvoidance(jtik.Point((0.98, 0.2)), bodies="links"), safe=0.01),
    )
    solution = ik.solve([math.cos(0.5), math.sin(0.5)], q0=[0.0], trace=True)
    assert solution.status is jtik.Status.BLOCKED
    assert solution.q[0] < math.atan2(0.2, 0.98)
    assert gaps(solution.q, [jtik.Circle((0.98, 0.2))]).min() >= 0.01 - ROUNDING


def test_what_starts_too_near_comes_no_nearer(problems):
    q, target = problems[0]
    near = jtik.Circle(planar_points(q)[2] + (0.0, 0.31), 0.3)  # 0.01 off a joint, or less off a link
    start = gaps(q, [near]).min()
    assert start < SAFE
    ik = solver(planar(5), field=[near])
    trace = ik.solve(target, q0=q, trace=True, max_iterations=200).trace
    least = [gaps(p, [near]).min() for p in trace.q]
    assert min(least) >= start - 1e-6


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


def test_limits_and_clearances_together(problems):
    robot = planar(5, lower=-1.5, upper=1.5)
    ik = solver(robot, criteria=JointCentering())
    for q, target in problems[:4]:
        trace = ik.solve(target, q0=q, max_iterations=300, trace=True).trace
        assert swept(trace) >= SAFE - ROUNDING
        assert np.abs(trace.q).max() <= 1.5


def test_rows_name_what_they_are(problems):
    q, target = problems[0]
    problem = solver(planar(5)).build(q, target)
    assert problem.P.shape == (6, 6)  # five joints, and the share of the task step
    assert problem.ub[-1] == 1


def test_travel_bounds_hold(rng):
    """No point of the body moves farther, for a unit of one joint, than its bound."""
    for robot in (planar(4), dh_arm(6, 1), jtik.Robot.vehicle(2, vehicle_lower=-1, vehicle_upper=1)):
        bound = travels(robot)
        for _ in range(20):
            q = robot.random_configuration(rng)
            for frame in robot.frame_names:
                moved = np.linalg.norm(robot.jacobian(q, frame)[:3], axis=0)
                assert (moved <= bound + 1e-9).all()


class TestRefusals:
    def test_a_strategy_without_a_program(self):
        with pytest.raises(jtik.ArgumentError, match="clearances.*hybrid\\+qp"):
            solver(planar(3), "hybrid")

    def test_two_of_one_name(self):
        one = jtik.Clearance(ObstacleAvoidance(FIELD))
        with pytest.raises(jtik.ArgumentError, match="name"):
            jtik.InverseKinematics(planar(3), jtik.FrameTask(), strategy="hybrid+qp", clearances=[one, one])

    def test_what_is_no_clearance(self):
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
        ],
    )
    def test_values(self, options, named):
        with pytest.raises(jtik.ArgumentError, match=named):
            jtik.Clearance(ObstacleAvoidance(FIELD), **options)

    def test_a_measure_without_distances(self):
        with pytest.raises(jtik.ArgumentError, match="measure"):
            jtik.Clearance(JointCentering())
