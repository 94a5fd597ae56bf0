"""Gravity torques, mass matrices and centres of mass against Pinocchio: robot files, built-in arms, random trees."""

from __future__ import annotations

import functools
from importlib import metadata
from pathlib import Path

import numpy as np
import pytest

import jtik
from jtik.interop.pinocchio_model import PinocchioCorrespondence
from jtik.robot import JointType, Mass

from ..conftest import random_mass, slow
from .random_trees import random_tree

pin = pytest.importorskip("pinocchio")

pytestmark = pytest.mark.robots

AGREEMENT = 1e-10
"""[N m], [kg m^2], [m], relative to the largest entry where that exceeds 1."""

FILES = {
    "panda": ("panda.urdf", False),
    "ur5": ("ur5_robot.urdf", False),
    "xarm7": ("xarm7.urdf", False),
    "jaco2": ("kinova.urdf", False),
    "talos": ("talos_reduced.urdf", True),
    "talos fixed": ("talos_full_v2.urdf", False),
    "tiago": ("tiago_pro.urdf", True),
    "humanoid": ("romeo.urdf", True),
}


@functools.cache
def path_of(file):
    try:
        package = metadata.distribution("example-robot-data")
    except metadata.PackageNotFoundError:
        pytest.skip("example-robot-data is not installed")
    (found,) = [entry for entry in package.files if entry.name == file]
    return Path(package.locate_file(found)).resolve()


def theirs(robot, model, q):
    """Pinocchio's M, gravity torque and centre of mass, in the velocities of the robot."""
    correspondence, data = PinocchioCorrespondence(robot, model), model.createData()
    at, moves = correspondence.theirs(q), correspondence.moves(q)
    for joint in robot.joints:
        if joint.mimic is not None:
            found = model.joints[model.getJointId(joint.name)]
            value = joint.mimic.multiplier * q[robot.q_slice(joint.name)][0] + joint.mimic.offset
            at[found.idx_q : found.idx_q + found.nq] = value if found.nq == 1 else [np.cos(value), np.sin(value)]
            moves[found.idx_v, robot.v_slice(joint.name)] = joint.mimic.multiplier
    M = np.triu(pin.crba(model, data, at))
    M = M + np.triu(M, 1).T - np.diag(model.armature)
    torque = pin.computeGeneralizedGravity(model, data, at)
    return moves.T @ M @ moves, moves.T @ torque, pin.centerOfMass(model, data, at)


def assert_same(robot, model, q, *, center=True):
    __tracebackhide__ = True
    M, torque, com = theirs(robot, model, q)
    pairs = {"M": (robot.mass_matrix(q), M), "torque": (robot.gravity_torque(q), torque)}
    if center:
        pairs["centre of mass"] = robot.center_of_mass(q), com
    for what, (mine, other) in pairs.items():
        error = np.abs(mine - other).max() / max(1.0, np.abs(other).max())
        assert error <= AGREEMENT, f"{what} differs by {error:.3g}"


@pytest.mark.quick(2)
@pytest.mark.parametrize(("file", "free"), FILES.values(), ids=FILES)
def test_robot_files(file, free, rng):
    robot = jtik.Robot.from_urdf(path_of(file), free_base=free)
    root = [pin.JointModelFreeFlyer()] if free else []
    model = pin.buildModelFromUrdf(str(path_of(file)), *root)
    for _ in range(5):
        # Pinocchio's centre of mass is that of what moves; a fixed base has a mass here as well
        assert_same(robot, model, robot.random_configuration(rng), center=free)


@pytest.mark.parametrize("name", ["xarm7", "jaco2"])
def test_built_in_arms_have_the_masses_of_the_files(name):
    file, _ = FILES[name]
    robot, described = jtik.Robot.builtin(name), jtik.Robot.from_urdf(path_of(file))
    assert {frame for frame in described.masses if "finger" not in frame} == set(robot.masses)
    for frame, mass in robot.masses.items():
        other = described.masses[frame]
        assert mass.mass == other.mass
        assert mass.center == pytest.approx(other.center, abs=1e-15)
        assert mass.inertia == pytest.approx(other.inertia, abs=1e-15)
    assert np.array_equal(robot.effort_limit, described.effort_limit)


def test_the_built_in_panda_with_its_hand_closed(rng):
    robot, model = jtik.Robot.builtin("panda"), pin.buildModelFromUrdf(str(path_of("panda.urdf")))
    fingers = [model.getJointId(joint) for joint in model.names[1:] if joint not in robot.joint_names]
    model = pin.buildReducedModel(model, fingers, pin.neutral(model))
    assert robot.effort_limit == pytest.approx(model.effortLimit)
    for q in (robot.home, *(robot.random_configuration(rng) for _ in range(5))):
        assert_same(robot, model, q, center=False)


def pinocchio_model(robot):
    """The robot in Pinocchio, joint by joint."""
    model = pin.Model()
    numbers, poses = {robot.base: 0}, {robot.base: np.eye(4)}
    made = {
        JointType.REVOLUTE: pin.JointModelRevoluteUnaligned,
        JointType.PRISMATIC: pin.JointModelPrismaticUnaligned,
        JointType.BALL: lambda axis: pin.JointModelSpherical(),
        JointType.FREE: lambda axis: pin.JointModelFreeFlyer(),
    }
    for joint in robot.joints:
        number, pose = numbers[joint.parent], poses[joint.parent] @ joint.origin
        if joint.is_moving:
            number = model.addJoint(number, made[joint.type](joint.axis), pin.SE3(pose), joint.name)
            pose = np.eye(4)
        numbers[joint.child], poses[joint.child] = number, pose
    for frame, mass in robot.masses.items():
        inertia = pin.Inertia(mass.mass, mass.center, mass.inertia)
        model.appendBodyToJoint(numbers[frame], inertia, pin.SE3(poses[frame]))
    return model


@pytest.mark.quick(4, slow=8)
@pytest.mark.parametrize("seed", [*range(12), *slow(*range(12, 30))])
def test_random_trees(seed):
    """Revolute, prismatic, ball and mimic joints in every order, planar ones in between, and lengths up to 1 km."""
    rng = np.random.default_rng(seed)
    tree = random_tree(rng).robot
    frames = [frame for frame in tree.frame_names if rng.random() < 0.8 or frame == tree.tip]
    masses = {frame: random_mass(rng) for frame in frames}
    robot = jtik.Robot(tree.joints, masses=masses)  # in space, for gravity along z
    model = pinocchio_model(robot)
    for _ in range(3):
        assert_same(robot, model, robot.random_configuration(rng), center=tree.base not in masses)


def test_a_point_mass_is_heavier_than_the_same_at_its_joint(rng):
    """The comparison can fail: without its inertia a robot differs."""
    robot = jtik.Robot.builtin("panda")
    model = pinocchio_model(robot)
    points = robot.with_masses({frame: Mass(mass.mass, mass.center) for frame, mass in robot.masses.items()})
    with pytest.raises(AssertionError, match="M differs by"):
        assert_same(points, model, robot.home, center=False)
