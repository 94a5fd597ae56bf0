"""Poses, Jacobians and integration against MuJoCo, for a tree with every type of joint."""

from __future__ import annotations

import numpy as np
import pytest

mujoco = pytest.importorskip("mujoco")

from scipy.spatial.transform import Rotation  # noqa: E402

from .conftest import make_mixed, poses_of_interest  # noqa: E402

POSE_TOLERANCE = 1e-12
JACOBIAN_TOLERANCE = 1e-12
STEP_TOLERANCE = 1e-12


def mjcf(robot):
    """The same tree as MJCF, written from the joints alone; a site marks every frame."""
    kinds = {"revolute": "hinge", "prismatic": "slide", "ball": "ball"}

    def numbers(values):
        return " ".join(repr(float(value)) for value in values)

    def body(joint):
        R = Rotation.from_matrix(joint.origin[:3, :3])
        quat = np.roll(R.as_quat(), 1)
        kind = joint.type.value
        lines = [f'<body name="{joint.child}" pos="{numbers(joint.origin[:3, 3])}" quat="{numbers(quat)}">']
        if kind == "free":
            lines.append(f'<freejoint name="{joint.name}"/>')
        elif kind in kinds:
            axis = f' axis="{numbers(joint.axis)}"' if kind != "ball" else ""
            lines.append(f'<joint name="{joint.name}" type="{kinds[kind]}"{axis}/>')
        lines.append(f'<site name="{joint.child}"/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>')
        lines += [body(child) for child in robot.joints if child.parent == joint.child]
        return "\n".join([*lines, "</body>"])

    tops = "\n".join(body(joint) for joint in robot.joints if joint.parent == robot.base)
    return f'<mujoco><compiler angle="radian"/><worldbody>{tops}</worldbody></mujoco>'


@pytest.fixture(scope="module")
def pair():
    robot = make_mixed()
    model = mujoco.MjModel.from_xml_string(mjcf(robot))
    assert (model.nq, model.nv) == (robot.nq, robot.n)
    return robot, model


def q_order(robot, model):
    """MuJoCo numbers joints depth first: the index of each entry of the robot in MuJoCo's vectors."""
    q, v = [], []
    for joint in robot.independent_joints:
        number = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, joint.name)
        q += [model.jnt_qposadr[number] + i for i in range(joint.type.nq)]
        v += [model.jnt_dofadr[number] + i for i in range(joint.type.nv)]
    return np.array(q), np.array(v)


def test_the_orders_of_the_joints_differ(pair):
    q, v = q_order(*pair)
    assert sorted(q) == list(range(len(q)))
    assert list(v) != sorted(v)


def test_poses_and_jacobians_agree(pair):
    robot, model = pair
    data = mujoco.MjData(model)
    order_q, order_v = q_order(robot, model)
    frames = robot.frame_names[1:]
    for q in poses_of_interest(robot):
        data.qpos[order_q] = q
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        for frame in frames:
            site = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, frame)
            T = robot.pose(q, frame)
            assert T[:3, 3] == pytest.approx(data.site_xpos[site], abs=POSE_TOLERANCE)
            assert T[:3, :3] == pytest.approx(data.site_xmat[site].reshape(3, 3), abs=POSE_TOLERANCE)
            J = np.zeros((6, model.nv))
            mujoco.mj_jacSite(model, data, J[:3], J[3:], site)
            assert robot.jacobian(q, frame) == pytest.approx(J[:, order_v], abs=JACOBIAN_TOLERANCE)


def test_integration_and_difference_agree(pair):
    robot, model = pair
    order_q, order_v = q_order(robot, model)
    generator = np.random.default_rng(3)
    for scale in (0.0, 1e-9, 0.1, 1.5):
        q = robot.random_configuration(generator)
        dq = scale * generator.uniform(-1, 1, robot.n)
        theirs_q, theirs_v = np.zeros(model.nq), np.zeros(model.nv)
        theirs_q[order_q], theirs_v[order_v] = q, dq
        start = theirs_q.copy()
        mujoco.mj_integratePos(model, theirs_q, theirs_v, 1.0)
        ours = robot.integrate(q, dq)
        assert ours == pytest.approx(theirs_q[order_q], abs=STEP_TOLERANCE)
        back = np.zeros(model.nv)
        mujoco.mj_differentiatePos(model, back, 1.0, start, theirs_q)
        assert robot.difference(q, ours) == pytest.approx(back[order_v], abs=1e-8)
        assert robot.difference(q, ours) == pytest.approx(dq, abs=STEP_TOLERANCE)
