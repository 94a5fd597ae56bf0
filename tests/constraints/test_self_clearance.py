"""Clearances between a robot's own bodies: both ends of a distance move, and the bound holds for their difference."""

from __future__ import annotations

import functools

import casadi
import numpy as np
import pytest

import jtik
from jtik._step.clearances import clearance_model
from jtik.constraints.clearance import SAMPLES
from jtik.geometry import segment_distances
from jtik.robot.collisions.frame_poses import frame_poses
from jtik.robot.collisions.reach import axis_point
from jtik_formulations import JointCentering, SelfCollision

from .._step.conftest import problem_of
from ..conftest import dh_arm, planar, shared_solver, slow
from ..criteria.mujoco_bodies import Judge
from .random_trees import far_out, path, positions, tree
from .test_path_bound import FINE, below_chord, bound, smoothed

ROUNDING = 1e-9


ROBOTS = {"planar": lambda rng: planar(4), "spatial": lambda rng: dh_arm(6, 1), "tree": lambda rng: tree(rng, 6)}


@pytest.mark.quick(1)
@pytest.mark.parametrize("seed", [0, *slow(1, 2)])
@pytest.mark.parametrize("robot", ROBOTS)
def test_the_smoothed_distance_of_two_moving_points_is_at_most_so_far_below_its_chord(robot, seed):
    """The bound for one moving point holds for two: no joint between them moves both in the frame that carries both."""
    rng = np.random.default_rng(seed)
    robot = ROBOTS[robot](rng)
    for _ in range(30):
        q, rho = far_out(robot, rng), rng.uniform(0.01, 0.5)
        dq = rng.uniform(-1, 1, robot.n) * 10 ** rng.uniform(-2, 0)
        way = path(robot, q, robot.integrate(q, dq), SAMPLES * FINE + 1)
        places = positions(robot, way)
        dip = bound(robot, q, dq, rho) / (8 * SAMPLES**2) * (1 + 1e-6) + 1e-9
        frames = list(places)
        for _ in range(8):
            a, b = (places[frames[i]] for i in rng.choice(len(frames), 2, replace=False))
            psi = smoothed(np.linalg.norm(a - b, axis=-1), rho)
            assert below_chord(psi) <= dip


def test_the_bound_is_attained_by_two_arms_that_turn_past_each_other():
    """Two links on one base, each by its own joint: as fast as both together."""
    joints = [
        jtik.robot.Joint("left", jtik.JointType.REVOLUTE, "base", "left"),
        jtik.robot.Joint("right", jtik.JointType.REVOLUTE, "base", "right"),
        jtik.robot.Joint("end", jtik.JointType.FIXED, "left", "a", origin=_shift(1.0)),
        jtik.robot.Joint("other", jtik.JointType.FIXED, "right", "b", origin=_shift(1.2)),
    ]
    robot, rho, q, dq = jtik.Robot(joints), 0.2, np.array([-0.02, 0.02]), np.array([0.16, -0.16])
    places = positions(robot, q + np.linspace(0, 1, SAMPLES * FINE + 1)[:, None] * dq)
    below = below_chord(smoothed(np.linalg.norm(places["a"] - places["b"], axis=-1), rho))
    assert 0.5 * bound(robot, q, dq, rho) / (8 * SAMPLES**2) <= below <= bound(robot, q, dq, rho) / (8 * SAMPLES**2)


def _shift(x):
    pose = np.eye(4)
    pose[0, 3] = x
    return pose


@functools.cache
def judged(name):
    """A robot, its pairs, live parameters, and (q, dq, parameters) -> whether the step keeps its clearance."""
    robot = {"planar": lambda: planar(5), "spatial": lambda: dh_arm(6, 2), "panda": lambda: jtik.Robot.builtin("panda")}
    robot = robot[name]()
    measure = SelfCollision(radius=0.03)
    problem = problem_of(robot, clearances=[jtik.Clearance(measure, safe=0.05)])
    live = problem.terms.parameters
    q, dq, parameters = casadi.SX.sym("q", robot.n), casadi.SX.sym("dq", robot.n), live.symbols()
    limits = casadi.SX(robot.lower), casadi.SX(robot.upper)
    model = clearance_model(problem, q, problem.measured.clearance(q, parameters), parameters, limits)
    return robot, measure.pairs(robot), live, casadi.Function("judged", [q, dq, parameters], [model.keeps(dq)])


def smallest_distances(robot, q, pairs):
    """The smallest distance of all pairs at configurations (N, nq), (N,)."""
    poses = frame_poses(robot, q, {frame for body in pairs.bodies.values() for frame in body.frames})
    ends = {
        name: [np.broadcast_to(axis_point(poses, body, end, robot.dimension), (len(q), 3)) for end in (0, 1)]
        for name, body in pairs.bodies.items()
    }
    found = []
    for pair in pairs:
        radius = pairs.bodies[pair.first].radius + pairs.bodies[pair.second].radius
        found.append(segment_distances(*ends[pair.first], *ends[pair.second]) - radius)
    return np.min(found, axis=0)


@pytest.mark.quick(1)
@pytest.mark.parametrize("name", ["planar", "spatial", *slow("panda")])
def test_a_step_that_is_judged_safe_is_safe_on_its_whole_path(name, rng):
    """The safe distance is near the smallest one on the path, or between it and the smallest one at the samples."""
    robot, pairs, live, keeps = judged(name)
    kept, tight, at_samples, broken = 0, 0, 0, 0
    for trial in range(150):
        q = robot.random_configuration(rng)
        dq = rng.uniform(-1, 1, robot.n) * 10 ** rng.uniform(-2, 0)
        dq = np.clip(q + dq, robot.lower, robot.upper) - q
        way = q + np.linspace(0, 1, SAMPLES * FINE + 1)[:, None] * dq
        gaps = smallest_distances(robot, way, pairs)
        if trial % 2:
            safe = gaps.min() + rng.choice([-1, 1]) * rng.exponential(0.002)
        else:
            safe = gaps.min() + rng.uniform() * (gaps[::FINE].min() - gaps.min())
        if safe < 0 or gaps[0] < safe:
            continue
        live["clearance.safe"] = safe
        at_samples += gaps[::FINE].min() >= safe > gaps.min()
        if float(keeps(q, dq, live.memory)):
            kept += 1
            tight += gaps.min() - safe < 0.005
            broken += gaps.min() < safe - ROUNDING
    assert broken == 0
    assert kept >= 8
    assert tight >= 4
    assert at_samples > 0  # safe at the samples only


SAFE = 0.005


@functools.cache
def problems(count):
    """Starts of a Panda and poses, both with its bodies 2 cm apart, and the judge."""
    robot, rng = jtik.Robot.builtin("panda"), np.random.default_rng(5)
    judge, found = Judge(robot, robot.collision_pairs()), []
    while len(found) < count:
        start, goal = (robot.random_configuration(rng) for _ in range(2))
        if min(judge.distances(start).min(), judge.distances(goal).min()) > 0.02:
            found.append((start, robot.position(goal)))
    return robot, judge, found


def swept(judge, trace):
    """The smallest distance on the straight lines in joint space between the iterates of a trace."""
    smallest = np.inf
    for start, end in zip(trace.q[:-1], trace.q[1:], strict=True):
        if not np.array_equal(start, end):
            shares = np.linspace(0, 1, 6)[1:]
            smallest = min(smallest, *[judge.distances(start + share * (end - start)).min() for share in shares])
    return smallest


@pytest.mark.quick(0, slow=2)
@pytest.mark.parametrize(
    ("criteria", "count"),
    [
        (None, 4),
        *(pytest.param(each, 8, marks=pytest.mark.slow) for each in (None, JointCentering(), SelfCollision())),
    ],
)
def test_no_accepted_step_of_a_panda_brings_its_bodies_together(criteria, count):
    robot, judge, found = problems(count)
    clearance = jtik.Clearance(SelfCollision(), safe=SAFE)
    ik = shared_solver(robot, jtik.FrameTask(), criteria=criteria, clearances=clearance, strategy="hybrid+qp")
    plain = shared_solver(robot, jtik.FrameTask(), strategy="hybrid+qp")
    reached, through = 0, 0
    for start, goal in found:
        solution = ik.solve(goal, q0=start, max_iterations=200, trace=True)
        assert swept(judge, solution.trace) >= SAFE - ROUNDING
        assert judge.distances(solution.q).min() >= SAFE - ROUNDING
        reached += solution.position_error < 1e-5
        through += swept(judge, plain.solve(goal, q0=start, max_iterations=200, trace=True).trace) < 0
    assert reached >= count / 2
    assert through >= count / 6  # without, some go through the body


def test_what_blocks_a_solve_is_named():
    """The end effector of a planar arm is sent onto its own first link, which cannot turn away."""
    robot = planar(4, lower=(-0.01, -3.0, -3.0, -3.0), upper=(0.01, 3.0, 3.0, 3.0))
    clearance = jtik.Clearance(SelfCollision(), safe=0.02)
    ik = shared_solver(robot, jtik.FrameTask(), clearances=clearance, strategy="hybrid+qp")
    solution = ik.solve([0.5, 0.0], q0=[0.0, 1.2, 1.2, 1.0])
    assert solution.position_error > 0.05
    assert solution.active_clearances
    assert "clearance: link1-link2 to link4-tip" in solution.active_clearances


def test_a_pair_whose_gain_is_zero_blocks_nothing():
    robot = planar(4)
    clearance = jtik.Clearance(SelfCollision(), safe=0.02)
    ik = shared_solver(robot, jtik.FrameTask(), clearances=clearance, strategy="hybrid+qp")
    ik.parameters["clearance.gains"] = np.zeros(3)
    solution = ik.solve([0.5, 0.0], q0=[0.0, 1.2, 1.2, 1.0])
    assert solution.position_error < 1e-6
    assert not solution.active_clearances


@pytest.mark.slow
def test_bodies_that_overlap_at_the_start_are_separated():
    robot, judge, _ = problems(12)
    clearance = jtik.Clearance(SelfCollision(), safe=SAFE)
    ik = shared_solver(robot, jtik.FrameTask(), clearances=clearance, strategy="hybrid+qp")
    rng, starts = np.random.default_rng(2), []
    while len(starts) < 6:
        q = robot.random_configuration(rng)
        if -0.03 < judge.distances(q).min() < 0:
            starts.append(q)
    for q in starts:
        assert judge.distances(ik.solve(robot.position(q), q0=q).q).min() >= SAFE
