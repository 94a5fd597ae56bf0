"""Full humanoids on a free base: hands, feet and the centre of mass at once, every solution checked by Pinocchio.

The packages are those of test_urdf_pinocchio.py: ``pip install ".[test,robots]"``.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

import numpy as np
import pytest

import jtik
from jtik_formulations import JointCentering

from ..conftest import shared_solver

pin = pytest.importorskip("pinocchio")

pytestmark = pytest.mark.robots

TOLERANCE = 1e-6
"""Tolerance of a solve [m], [rad]: norms over all tasks together."""


def file(name):
    try:
        package = metadata.distribution("example-robot-data")
    except metadata.PackageNotFoundError:
        pytest.skip("example-robot-data is not installed")
    return next(Path(package.locate_file(path)) for path in package.files if path.name == name)


@dataclass(frozen=True, eq=False)
class Humanoid:
    """A humanoid robot.

    Attributes:
        urdf: name of its file.
        hands: frames of the hands.
        feet: frames of the feet.
        bent: positions of joints at which it stands with bent knees and elbows [rad].
    """

    urdf: str
    hands: tuple[str, str]
    feet: tuple[str, str]
    bent: dict[str, float]

    @functools.cached_property
    def robot(self):
        return jtik.Robot.from_urdf(file(self.urdf), free_base=True)

    @functools.cached_property
    def standing(self):
        q = self.robot.neutral.copy()
        for joint, angle in self.bent.items():
            q[self.robot.q_slice(joint)] = angle
        return q

    def tasks(self, *, feet):
        poses = [*self.hands, *(self.feet if feet else ())]
        return [*(jtik.FrameTask(frame, "pose") for frame in poses), jtik.CenterOfMassTask(axes="xy" if feet else None)]

    def posture(self, rng):
        """Within the limits, about standing."""
        robot = self.robot
        spread = np.concatenate([np.full(3, 0.1), np.full(3, 0.2), np.full(robot.n - 6, 0.4)])
        q = robot.integrate(self.standing, rng.uniform(-spread, spread))
        return np.clip(q, robot.lower, robot.upper)


class Oracle:
    """The same robot in Pinocchio."""

    def __init__(self, humanoid):
        self.robot = humanoid.robot
        self.model = pin.buildModelFromUrdf(str(file(humanoid.urdf)), pin.JointModelFreeFlyer())
        self.data = self.model.createData()

    def at(self, q):
        """Pose of every frame and the centre of mass."""
        x, y, z, *quaternion = q[self.robot.q_slice("free_base")]
        theirs = pin.neutral(self.model)
        theirs[:7] = [x, y, z, *np.roll(quaternion, -1)]
        for name in self.robot.joint_names[1:]:
            theirs[self.model.joints[self.model.getJointId(name)].idx_q] = q[self.robot.q_slice(name)][0]
        pin.framesForwardKinematics(self.model, self.data, theirs)
        poses = {frame.name: pose.homogeneous for frame, pose in zip(self.model.frames, self.data.oMf, strict=True)}
        return poses, pin.centerOfMass(self.model, self.data, theirs).copy()


def flexed(left, right, rest):
    """Hips, knees and ankles, and the rest."""
    return dict(zip((*left, *right), (-0.4, 0.8, -0.4) * 2, strict=True)) | rest


TALOS = Humanoid(
    "talos_reduced.urdf",
    hands=("gripper_left_base_link", "gripper_right_base_link"),
    feet=("left_sole_link", "right_sole_link"),
    bent=flexed(
        [f"leg_left_{k}_joint" for k in (3, 4, 5)],
        [f"leg_right_{k}_joint" for k in (3, 4, 5)],
        {
            "arm_left_2_joint": 0.4,
            "arm_right_2_joint": -0.4,
            "arm_left_4_joint": -1.2,
            "arm_right_4_joint": -1.2,
        },
    ),
)
G1 = Humanoid(
    "g1_29dof_rev_1_0.urdf",
    hands=("left_rubber_hand", "right_rubber_hand"),
    feet=("left_ankle_roll_link", "right_ankle_roll_link"),
    bent=flexed(
        [f"left_{part}_joint" for part in ("hip_pitch", "knee", "ankle_pitch")],
        [f"right_{part}_joint" for part in ("hip_pitch", "knee", "ankle_pitch")],
        {
            "left_shoulder_roll_joint": 0.3,
            "right_shoulder_roll_joint": -0.3,
            "left_elbow_joint": 0.6,
            "right_elbow_joint": 0.6,
        },
    ),
)


def check(humanoid, ik, oracle, targets, solution):
    """Pinocchio finds the targets met at the solution."""
    full, robot = ik.full_configuration(solution.q), humanoid.robot
    assert (robot.lower <= full).all()
    assert (full <= robot.upper).all()
    assert np.linalg.norm(full[robot.q_slice("free_base")][3:]) == pytest.approx(1.0, abs=1e-12)
    poses, center = oracle.at(full)
    away, rotations = [], []
    for task in ik.tasks.tasks:
        desired = targets[task.name]
        if isinstance(task, jtik.CenterOfMassTask):
            rows = slice(0, 2) if task.axes else slice(0, 3)
            away.append(center[rows] - desired[rows])
        else:
            found = poses[task.frame]
            away.append(found[:3, 3] - desired[:3, 3])
            rotations.append(pin.log3(desired[:3, :3].T @ found[:3, :3]))
    assert np.linalg.norm(np.concatenate(away)) <= TOLERANCE + 1e-10
    assert np.linalg.norm(np.concatenate(rotations)) <= TOLERANCE + 1e-10


def targets_at(oracle, ik, q):
    """Targets that the posture q meets, by Pinocchio's own kinematics."""
    poses, center = oracle.at(q)
    frames = {task.name: getattr(task, "frame", None) for task in ik.tasks.tasks}
    return {name: center if frame is None else poses[frame] for name, frame in frames.items()}


@functools.cache
def oracle_of(humanoid):
    return Oracle(humanoid)


@pytest.mark.quick(1, slow=2)
@pytest.mark.parametrize(
    ("humanoid", "feet", "strategy", "criteria"),
    [
        (TALOS, True, "hybrid", None),
        (G1, True, "damped", None),
        pytest.param(TALOS, True, "newton", None, marks=pytest.mark.slow),
        pytest.param(TALOS, False, "hybrid", JointCentering(), marks=pytest.mark.slow),
        pytest.param(G1, True, "damped", JointCentering(), marks=pytest.mark.slow),
    ],
    ids=["talos-hybrid", "g1-damped", "talos-newton", "talos-hands-centred", "g1-centred"],
)
def test_hands_feet_and_balance_are_reached_within_the_limits(humanoid, feet, strategy, criteria):
    robot, oracle, rng = humanoid.robot, oracle_of(humanoid), np.random.default_rng(1)
    ik = shared_solver(robot, humanoid.tasks(feet=feet), strategy=strategy, criteria=criteria, joints="all")
    assert ik.robot.nq == ik.robot.n + 1
    for _ in range(4):
        targets = targets_at(oracle, ik, humanoid.posture(rng))
        solution = ik.solve(targets, q0=humanoid.standing, max_iterations=200, until="reached")
        assert solution.converged, solution
        check(humanoid, ik, oracle, targets, solution)
        if criteria is None:
            assert solution.iterations <= 15


@pytest.mark.slow
def test_a_distant_posture_is_found_by_restarts():
    """Any posture within the limits, the base at any position and rotated by up to 3 rad."""
    robot, oracle, rng = TALOS.robot, oracle_of(TALOS), np.random.default_rng(2)
    ik = shared_solver(robot, TALOS.tasks(feet=True), strategy="damped", joints="all")
    for _ in range(10):
        q = robot.random_configuration(rng)
        targets = targets_at(oracle, ik, q)
        solution = ik.solve(targets, q0=TALOS.standing, restarts=100, max_iterations=300)
        assert solution.converged, solution
        check(TALOS, ik, oracle, targets, solution)


@pytest.mark.slow
def test_a_hand_out_of_reach_is_reported():
    robot, oracle = TALOS.robot, oracle_of(TALOS)
    ik = shared_solver(robot, TALOS.tasks(feet=True), joints="all")
    targets = targets_at(oracle, ik, TALOS.standing)
    targets[TALOS.hands[0]] = targets[TALOS.hands[0]].copy()
    targets[TALOS.hands[0]][:3, 3] += (4.0, 0.0, 0.0)
    before = ik.solve(targets, q0=TALOS.standing, max_iterations=0)
    solution = ik.solve(targets, q0=TALOS.standing, max_iterations=200)
    assert solution.status in (jtik.Status.LIMITS, jtik.Status.ITERATION_LIMIT)
    assert 2.0 < np.linalg.norm(solution.error) < np.linalg.norm(before.error)
    assert solution.active_limits
    assert (robot.lower <= solution.q).all()
    assert (solution.q <= robot.upper).all()


@pytest.mark.slow
def test_a_path_of_the_hands_is_tracked_with_fixed_feet():
    """Both hands move on half circles of 5 cm; the base moves with them, every joint within its speed limit."""
    robot, oracle = G1.robot, oracle_of(G1)
    ik = shared_solver(robot, G1.tasks(feet=True), strategy="damped", joints="all")
    home, path = targets_at(oracle, ik, G1.standing), []
    for angle in np.linspace(0, np.pi, 15):
        targets = {name: target.copy() for name, target in home.items()}
        for hand in G1.hands:
            targets[hand][:3, 3] += 0.05 * np.array([0.0, 1 - np.cos(angle), np.sin(angle)])
        path.append(targets)
    motion = ik.track(path, q0=G1.standing, dt=0.05)
    assert motion.converged
    assert (np.abs(motion.dq) <= robot.velocity_limit + 1e-9).all()
    q = G1.standing
    for row, velocity in zip(motion.q, motion.dq, strict=True):
        assert robot.integrate(q, 0.05 * velocity) == pytest.approx(row, abs=1e-9)
        q = row
    assert motion.q.shape == (15, robot.nq)
    assert motion.dq.shape == (15, robot.n)
