"""Bounds of a step's motion: valid on every path of every robot, whatever limits hold, and so are the clearances.

Its tests are thinned: ``--full`` runs all of them.
"""

from __future__ import annotations

import itertools
import math

import casadi
import numpy as np
import pytest

import jtik
from jtik.constraints.motion_bound import MotionBound
from jtik.robot import Joint, JointType, Mimic
from jtik_formulations import ObstacleAvoidance

from ..conftest import as_moved, ball_arm, dh_arm, floating_arm, planar, shared_solver, slow
from .random_trees import far_out, path, positions, tree

pytestmark = pytest.mark.thinned

SAFE = 0.05
ROUNDING = 1e-9
SPHERES = 3


def numbers(values):
    return np.array([float(casadi.DM(value)) for value in values])


def bounds(robot, q, dq=None):
    dq = dq if dq is None else casadi.SX(dq)
    return numbers(MotionBound(robot, casadi.SX(q)).lever_arms(dq))


@pytest.mark.quick(1)
@pytest.mark.parametrize("seed", [0, 1, 2, *slow(3, 4, 5)])
def test_no_frame_moves_farther_than_its_bound(seed):
    """By differences along the path of a displacement, in kinematics of its own."""
    rng = np.random.default_rng(seed)
    robot = tree(rng, 6)
    for _ in range(20):
        q, dq = far_out(robot, rng), rng.uniform(-1, 1, robot.n)
        dq *= rng.random(robot.n) < 0.4  # the fewer move, the closer is the bound
        motion = MotionBound(robot, casadi.SX(q))
        travelled, turned = numbers(motion.lengths(casadi.SX(dq)))
        way = path(robot, q, robot.integrate(q, dq), 401)
        for places in positions(robot, way).values():
            first = np.diff(places, axis=0) * 400
            second = np.diff(places, 2, axis=0) * 400**2
            assert np.linalg.norm(first, axis=1).max() <= travelled * (1 + 1e-9) + 1e-9
            assert np.linalg.norm(second, axis=1).max() <= travelled * turned * (1 + 1e-4) + 1e-5


def test_without_prismatic_joints_the_bounds_are_constant():
    assert bounds(planar(3), np.zeros(3)).tolist() == [3, 2, 1]
    motion = MotionBound(dh_arm(6, 1), casadi.SX.sym("q", 6))
    assert all(isinstance(arm, float) for arm in motion.lever_arms(casadi.SX.sym("dq", 6)))


def test_a_prismatic_joint_lengthens_the_lever_arm_of_the_joints_before_it():
    robot = jtik.Robot(
        [
            Joint("turn", JointType.REVOLUTE, "base", "link"),
            Joint("out", JointType.PRISMATIC, "link", "rod", axis=np.array([1.0, 0.0, 0.0])),
        ],
        planar=True,
    )
    assert bounds(robot, [0.0, -2.0]).tolist() == [2, 1]
    assert bounds(robot, [0.0, -2.0], [0.3, -0.5]).tolist() == [2.5, 1]
    assert bounds(robot, [0.0, -2.0], [0.3, 0.5]).tolist() == [2, 1]


def test_mimic_joints_count_with_their_leader():
    """A rod goes out by 2 q + 1 as the joint before it turns by q, and a link behind it turns by -3 q."""
    x = np.array([1.0, 0.0, 0.0])
    robot = jtik.Robot(
        [
            Joint("turn", JointType.REVOLUTE, "base", "link"),
            Joint("out", JointType.PRISMATIC, "link", "rod", axis=x, mimic=Mimic("turn", 2.0, 1.0)),
            Joint("back", JointType.REVOLUTE, "rod", "hand", mimic=Mimic("turn", -3.0)),
            Joint(
                "end", JointType.FIXED, "hand", "end", origin=np.block([[np.eye(3), 0.5 * x[:, None]], [0, 0, 0, 1]])
            ),
        ],
        planar=True,
    )
    motion = MotionBound(robot, casadi.SX([0.2]))
    assert numbers(motion.lever_arms(casadi.SX([0.1]))) == pytest.approx([1.6 + 0.5 + 2.0 + 3 * 0.5])
    assert motion.rotations.tolist() == [4.0]


def test_the_order_of_the_joints_does_not_matter():
    for seed in range(5):
        robot = tree(np.random.default_rng(seed), 6)
        again = jtik.Robot(reversed(robot.joints), tip=robot.tip)
        q = robot.random_configuration(np.random.default_rng(seed))
        other = np.zeros(again.nq)
        for joint in robot.joints:
            if joint.is_independent:
                other[again.q_slice(joint.name)] = q[robot.q_slice(joint.name)]
        ours, theirs = bounds(robot, q), bounds(again, other)
        for joint in robot.joints:
            if joint.is_independent:
                assert theirs[again.v_slice(joint.name)] == pytest.approx(ours[robot.v_slice(joint.name)])


ARMS = {"planar": lambda: planar(4), "spatial": lambda: dh_arm(6, 1), "ball": ball_arm, "floating": floating_arm}


@pytest.mark.parametrize("build", ARMS.values(), ids=ARMS)
def test_no_column_of_the_jacobian_is_longer(build, rng):
    robot = build()
    for _ in range(20):
        q = robot.random_configuration(rng)
        bound = bounds(robot, q)
        for frame in robot.frame_names:
            assert (np.linalg.norm(robot.jacobian(q, frame)[:3], axis=0) <= bound + 1e-9).all()


def gaps(robot, q, centers, radii):
    """Distances of all moving frames to all spheres on the path through q (samples, nq)."""
    places = positions(robot, q)
    of_frames = np.stack([places[frame] for frame in robot.moving_frames], axis=1)
    return np.linalg.norm(of_frames[:, :, None] - centers, axis=-1) - radii


def between_samples(robot, trace, rng):
    """Small spheres on the way of an arm that does not avoid them, between the samples of its steps."""
    steps = [(a, b) for a, b in itertools.pairwise(as_moved(robot, trace.q)) if not np.array_equal(a, b)][:4]
    centers = []
    for k in rng.integers(len(steps), size=SPHERES):
        way = path(robot, *steps[k], 9)[1::2]
        frame = robot.moving_frames[rng.integers(len(robot.moving_frames))]
        centers.append(positions(robot, way)[frame][rng.integers(4)] + rng.normal(scale=0.02, size=3))
    return np.array(centers), rng.uniform(0.01, 0.1, SPHERES)


def steps_of_a_random_tree(seed, strategy, limits, count=8):
    """For each accepted step the smallest of what the distances on its path are above safe [m]."""
    rng = np.random.default_rng(seed)
    robot = tree(rng, 5)
    measure = ObstacleAvoidance([jtik.Sphere((99.0 + i, 0, 0), 0.1) for i in range(SPHERES)])
    ik = shared_solver(
        robot,
        jtik.FrameTask("end"),
        strategy=strategy,
        limits=limits,
        joints=[joint.name for joint in robot.joints if joint.is_independent],  # also those that move no task
        clearances=jtik.Clearance(measure, safe=SAFE, influence=math.inf),
    )
    far, found = ik.parameters["clearance.centers"].copy(), []
    for _ in range(count):
        q, target = far_out(robot, rng), robot.position(far_out(robot, rng))
        ik.parameters["clearance.centers"] = far
        free = ik.solve(target, q0=q, max_iterations=5, trace=True).trace
        if np.array_equal(free.q[0], free.q[-1]):
            continue
        centers, radii = between_samples(robot, free, rng)
        if gaps(robot, free.q[:1], centers, radii).min() < SAFE + 0.01:
            continue
        ik.parameters["clearance.centers"], ik.parameters["clearance.radii"] = centers, radii
        trace = ik.solve(target, q0=q, max_iterations=40, trace=True).trace
        for start, end in itertools.pairwise(as_moved(robot, trace.q)):
            if not np.array_equal(start, end):
                found.append(gaps(robot, path(robot, start, end, 81), centers, radii).min() - SAFE)
    return found


LIMITS = {
    "none": {},
    "off": {"lower": -0.1, "upper": 0.1},
    "one-sided": {"lower": -0.1},
    "both": {"lower": -0.1, "upper": 5.0},
}
"""Limits of a prismatic joint that is 4 m out; those of "off" do not hold."""


RODS = [(limits, before) for limits in LIMITS for before in (JointType.REVOLUTE, JointType.BALL, JointType.FREE)]


@pytest.mark.quick(3)
@pytest.mark.parametrize(
    ("limits", "before", "mimic"),
    [
        pytest.param(*rod, bool(mimic), id=f"{rod[0]}-{rod[1].value}-{kind}", marks=[] if quick else pytest.mark.slow)
        for row, rod in enumerate(RODS)
        for mimic, kind in enumerate(("own", "mimic"))
        for quick in [row % 2 == mimic]
    ],
)
def test_a_rod_that_is_far_out_does_not_jump_over_a_sphere(before, limits, mimic):
    """The rod's end sweeps 2 m in a step, and the sphere is between the samples of the step's path."""
    x, own = np.array([1.0, 0.0, 0.0]), LIMITS[limits]
    joints = [Joint("turn", before, "base", "link"), Joint("out", JointType.PRISMATIC, "link", "rod", axis=x, **own)]
    if mimic:  # the rod follows a small slider beside it
        follows = Mimic("slider", 10.0, -1.0)
        joints[1] = Joint("out", JointType.PRISMATIC, "link", "rod", axis=x, mimic=follows, **own)
        joints.append(Joint("slider", JointType.PRISMATIC, "link", "carriage", axis=x))
    robot = jtik.Robot(joints, tip="rod")
    q = robot.neutral.copy()
    q[robot.q_slice("out")] = 0.5 if mimic else 4.0
    place = robot.v_slice("turn").stop - 1  # about z

    def turned(angle):
        dq = np.zeros(robot.n)
        dq[place] = angle
        return robot.integrate(q, dq)

    clearance = jtik.Clearance(ObstacleAvoidance(jtik.Sphere((99.0, 0, 0), 0.1)), safe=0.02)
    ik = shared_solver(
        robot, jtik.FrameTask("rod"), strategy="weighted_qp", limits=limits != "off", clearances=clearance
    )
    target, passed = robot.position(turned(0.4)), 0
    free = ik.solve(target, q0=q, trace=True).trace.q[:2]
    for way in path(robot, *free, 9)[1::2]:
        center = robot.position(way)
        ik.parameters["clearance.centers"] = center[None]
        trace = ik.solve(target, q0=q, max_iterations=60, trace=True).trace
        for start, end in itertools.pairwise(as_moved(robot, trace.q)):
            rods = positions(robot, path(robot, start, end, 201))["rod"]
            assert np.linalg.norm(rods - center, axis=1).min() - 0.1 >= 0.02 - ROUNDING
        ends = positions(robot, np.array(free))["rod"]
        passed += np.linalg.norm(ends - center, axis=1).min() > 0.2
    assert passed >= 2  # a step that is judged by its ends would have been taken


CASES = [(seed, strategy) for seed in range(8) for strategy in ("weighted_qp", "hybrid+qp")]


@pytest.mark.quick(1, slow=4)
@pytest.mark.parametrize(
    ("seed", "strategy"), [pytest.param(*case, marks=pytest.mark.slow if case[0] >= 2 else ()) for case in CASES]
)
def test_no_accepted_step_of_a_random_tree_is_closer_than_safe(seed, strategy):
    assert min(steps_of_a_random_tree(seed, strategy, limits=bool(seed % 2)), default=0.0) >= -ROUNDING
