"""Every robot of the package ``example-robot-data``, all links, against Pinocchio and against MuJoCo.

A quick run reads one file of every folder, the largest; the others are variants of it.

Both packages are big, so they are an extra of their own: ``pip install ".[test,robots]"``. Without them these tests
are skipped.
"""

from __future__ import annotations

import functools
import math
import warnings
from importlib import metadata
from pathlib import Path

import numpy as np
import pytest

import jtik
from jtik.symbolic import function, horzcat, symbol
from jtik.symbolic.compile import CompiledFunction

pin = pytest.importorskip("pinocchio")
mujoco = pytest.importorskip("mujoco")

pytestmark = pytest.mark.robots

AGREEMENT = 1e-10
"""[m], [rad] and their ratios: rounding along chains of some dozens of joints and metres."""

CONFIGURATIONS = 5
NOT_A_ROBOT = "ur3.urdf"
"""The only file of the package without a link: an unexpanded macro."""


def described_robots():
    try:
        package = metadata.distribution("example-robot-data")
    except metadata.PackageNotFoundError:
        return []
    return sorted(Path(package.locate_file(file)).resolve() for file in package.files if file.suffix == ".urdf")


URDFS = described_robots()
ROBOTS = [path for path in URDFS if path.name != NOT_A_ROBOT]


def largest_of_each_folder():
    folders = {}
    for path in sorted(ROBOTS, key=lambda path: path.stat().st_size):
        folders[path.parent] = path
    return sorted(folders.values())


LARGEST = largest_of_each_folder()


def named(path):
    return path.stem


@functools.cache
def load(path):
    with warnings.catch_warnings():
        # the fingers of one robot mimic joints that do not exist
        warnings.filterwarnings("ignore", message=".*alex_psyonic_hands.*stays independent")
        # the antennas of TIAGo, and three links of a Romeo
        warnings.filterwarnings("ignore", message=".*(tiago|romeo_laas).*inertia with a negative principal moment")
        return jtik.Robot.from_urdf(path)


@functools.cache
def everything(path):
    """Pose (3, 4) and Jacobian (6, n) of every frame, side by side, in one call: configuration -> name -> both."""
    robot = load(path)
    q = symbol("q", robot.nq)
    kinematics = robot.at(q)
    upper = [kinematics.pose(frame)[:3, :] for frame in robot.frame_names]
    jacobians = [kinematics.jacobian(frame) for frame in robot.frame_names]
    compiled = CompiledFunction(function("everything", [q], [horzcat(*upper), horzcat(*jacobians)]))

    def evaluate(configuration):
        poses, columns = compiled(configuration)
        return {
            frame: (poses[:, 4 * k : 4 * k + 4], columns[:, robot.n * k : robot.n * (k + 1)])
            for k, frame in enumerate(robot.frame_names)
        }

    return evaluate


def configurations(robot):
    generator = np.random.default_rng(11)
    return [robot.random_configuration(generator) for _ in range(CONFIGURATIONS)]


def joint_values(robot, q):
    """Position of every moving joint, followers included, and its derivative with respect to v."""
    values = {}
    for joint in robot.joints:
        if joint.is_moving:
            ratio, offset = (joint.mimic.multiplier, joint.mimic.offset) if joint.mimic else (1.0, 0.0)
            column = robot.v_slice(joint.name).start
            values[joint.name] = ratio * q[robot.q_slice(joint.name)][0] + offset, column, ratio
    return values


def gathered(J, columns, n):
    """The Jacobian of v from that of all joints: the column of a follower is added to its leader's, times the ratio."""
    total = np.zeros((n, 6))
    theirs, ours, ratios = np.array(columns).reshape(-1, 3).T
    np.add.at(total, ours.astype(int), ratios[:, None] * J.T[theirs.astype(int)])
    return total.T


def assert_same(name, ours, pose, J):
    __tracebackhide__ = True
    for what, mine, theirs in (("pose", ours[0], pose), ("Jacobian", ours[1], J)):
        error = np.abs(mine - theirs).max(initial=0.0)
        assert error <= AGREEMENT, f"{what} of {name} differs by {error:.3g}"


def test_the_package_has_the_expected_robots():
    assert len(URDFS) >= 69
    assert len(ROBOTS) == len(URDFS) - 1


def test_the_file_that_is_not_a_robot_is_refused():
    path = next(path for path in URDFS if path.name == NOT_A_ROBOT)
    with pytest.raises(jtik.RobotFileError, match=r"ur3\.urdf: not a robot: it has no link"):
        jtik.Robot.from_urdf(path)


@pytest.mark.quick(8, slow=20)
@pytest.mark.filterwarnings("ignore:.*its limits, 0 to 0.548, are not kept")  # PR2: followers with the other sign
@pytest.mark.parametrize(
    "path", [path if path in LARGEST else pytest.param(path, marks=pytest.mark.slow) for path in ROBOTS], ids=named
)
def test_all_links_agree_with_pinocchio(path):
    robot, evaluate = load(path), everything(path)
    model = pin.buildModelFromUrdf(str(path))
    data = model.createData()
    links = {frame.name: number for number, frame in enumerate(model.frames) if frame.type == pin.FrameType.BODY}
    assert set(robot.frame_names) == set(links)
    for q in configurations(robot):
        theirs, columns = pin.neutral(model), []
        for name, (position, ours, ratio) in joint_values(robot, q).items():
            joint = model.joints[model.getJointId(name)]
            circle = joint.nq == 2
            theirs[joint.idx_q : joint.idx_q + joint.nq] = (
                [math.cos(position), math.sin(position)] if circle else position
            )
            columns.append((joint.idx_v, ours, ratio))
        assert len(columns) == model.nv
        pin.framesForwardKinematics(model, data, theirs)
        if model.nv:  # without a joint it crashes
            pin.computeJointJacobians(model, data, theirs)
        found = evaluate(q)
        for name, number in links.items():
            J = np.zeros((6, 0))
            if model.nv:
                J = pin.getFrameJacobian(model, data, number, pin.LOCAL_WORLD_ALIGNED)
            assert_same(name, found[name], data.oMf[number].homogeneous[:3], gathered(J, columns, robot.n))


def as_mujoco_reads_it(path):
    """MuJoCo's own model without meshes; None when it refuses the file."""
    try:
        spec = mujoco.MjSpec.from_file(str(path))
        for geom in spec.geoms:
            if geom.meshname:
                spec.delete(geom)
        for mesh in spec.meshes:
            spec.delete(mesh)
        spec.compiler.fusestatic = False
        return spec.compile()
    except ValueError:
        return None


@pytest.fixture(scope="module")
def quiet_mujoco():
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda message: None)
    yield
    mujoco.set_mju_user_warning(before)


@pytest.mark.slow
@pytest.mark.usefixtures("quiet_mujoco")
@pytest.mark.parametrize(
    ("paths", "least"),
    [pytest.param(LARGEST, 25, id="largest"), pytest.param(ROBOTS, 40, id="all", marks=pytest.mark.slow)],
)
def test_all_links_agree_with_mujoco_where_it_accepts_the_file(paths, least):
    taken = 0
    for path in paths:
        model = as_mujoco_reads_it(path)
        if model is None:
            continue
        taken += 1
        robot, evaluate, data = load(path), everything(path), mujoco.MjData(model)
        bodies = {model.body(number).name: number for number in range(model.nbody)}
        for q in configurations(robot):
            columns = []
            for name, (position, ours, ratio) in joint_values(robot, q).items():
                data.qpos[model.joint(name).qposadr[0]] = position
                columns.append((model.joint(name).dofadr[0], ours, ratio))
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            found = evaluate(q)
            for name in robot.frame_names:
                body = bodies[name]
                J = np.zeros((6, model.nv))
                mujoco.mj_jacBody(model, data, J[:3], J[3:], body)
                pose = np.column_stack([data.xmat[body].reshape(3, 3), data.xpos[body]])
                assert_same(f"{path.stem}'s {name}", found[name], pose, gathered(J, columns, robot.n))
    assert taken >= least


@pytest.mark.quick(1)
@pytest.mark.parametrize(
    "path", [path for path in ROBOTS if path.stem in ("talos_reduced", "g1_29dof_rev_1_0")], ids=named
)
def test_a_free_base_and_the_center_of_mass_agree_with_pinocchio(path):
    robot = jtik.Robot.from_urdf(path, free_base=True)
    assert (robot.nq, robot.n) == (load(path).nq + 7, load(path).n + 6)
    model = pin.buildModelFromUrdf(str(path), pin.JointModelFreeFlyer())
    data = model.createData()
    frame = model.getFrameId(robot.tip)
    for q in configurations(robot)[:5]:
        theirs = pin.neutral(model)
        x, y, z, *quaternion = q[robot.q_slice("free_base")]
        theirs[:7] = [x, y, z, *np.roll(quaternion, -1)]
        for name in robot.joint_names[1:]:
            theirs[model.joints[model.getJointId(name)].idx_q] = q[robot.q_slice(name)][0]
        pin.framesForwardKinematics(model, data, theirs)
        assert robot.pose(q) == pytest.approx(data.oMf[frame].homogeneous, abs=AGREEMENT)
        assert robot.center_of_mass(q) == pytest.approx(pin.centerOfMass(model, data, theirs), abs=AGREEMENT)


ALL_TYPES = """
<robot name="all"><link name="base"/><link name="a"/><link name="b"/><link name="c"/><link name="d"/><link name="e"/>
  <joint name="turn" type="continuous"><parent link="base"/><child link="a"/>
    <origin xyz="0.1 0.2 0.3" rpy="0.4 0.5 0.6"/><axis xyz="1 2 2"/></joint>
  <joint name="plane" type="planar"><parent link="a"/><child link="b"/>
    <origin xyz="0.3 0.2 0.1" rpy="-0.4 0.5 1.6"/><axis xyz="0 0 1"/></joint>
  <joint name="loose" type="floating"><parent link="b"/><child link="c"/><origin xyz="0 0.2 0.1" rpy="1 2 3"/></joint>
  <joint name="slide" type="prismatic"><parent link="c"/><child link="d"/>
    <origin xyz="0.1 0 0.1" rpy="3 2 1"/><axis xyz="0 -1 1"/>
    <limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
  <joint name="weld" type="fixed"><parent link="d"/><child link="e"/><origin xyz="0.1 0.1 0.1" rpy="3 2 1"/></joint>
</robot>"""


def test_every_type_of_joint_agrees_with_pinocchio():
    robot, model = jtik.Robot.from_urdf(ALL_TYPES), pin.buildModelFromXML(ALL_TYPES)
    data = model.createData()
    for q in configurations(robot):
        theirs = pin.neutral(model)
        turn, x, y, heading, px, py, pz, qw, qx, qy, qz, slide = q
        values = {
            "turn": [math.cos(turn), math.sin(turn)],
            "plane": [x, y, math.cos(heading), math.sin(heading)],
            "loose": [px, py, pz, qx, qy, qz, qw],
            "slide": [slide],
        }
        for name, value in values.items():
            joint = model.joints[model.getJointId(name)]
            theirs[joint.idx_q : joint.idx_q + joint.nq] = value
        pin.framesForwardKinematics(model, data, theirs)
        for frame in ("base", "a", "b", "c", "d", "e"):
            assert robot.pose(q, frame) == pytest.approx(data.oMf[model.getFrameId(frame)].homogeneous, abs=AGREEMENT)
