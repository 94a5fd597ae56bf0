"""Independent oracles: MuJoCo for poses, closed forms for planar arms."""

from __future__ import annotations

import functools

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation as Rotation

import jtik
from jtik.interop.mink import MujocoCorrespondence, to_mujoco

ARRIVED = 2e-6
"""Error of a solution to 1e-6 in another kinematics [m], [rad]."""


@functools.cache
def gallery(name):
    return jtik.Robot.builtin(name)


@functools.cache
def model_of(robot):
    model = to_mujoco(robot)
    return model, mujoco.MjData(model), MujocoCorrespondence(robot, model)


def mujoco_pose(robot, q, frame=None):
    """Pose (4, 4) of a frame by MuJoCo."""
    model, data, same = model_of(robot)
    data.qpos[:] = same.qpos(q)
    mujoco.mj_kinematics(model, data)
    body = data.body(frame or robot.tip)
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = body.xmat.reshape(3, 3), body.xpos
    return pose


def mujoco_jacobian(robot, q, frame=None):
    """Jacobian (6, n) of a frame by MuJoCo, for robots of revolute and prismatic joints in the model's order."""
    model, data, same = model_of(robot)
    data.qpos[:] = same.qpos(q)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    linear, angular = np.zeros((3, model.nv)), np.zeros((3, model.nv))
    mujoco.mj_jacBody(model, data, linear, angular, data.body(frame or robot.tip).id)
    return np.vstack([linear, angular])


def distance_to(robot, q, target, kind, frame=None):
    """Error of q [m + rad] against a target in the form the generators write, by MuJoCo."""
    pose, size = mujoco_pose(robot, q, frame), robot.dimension
    if kind == "position":
        return np.linalg.norm(pose[:size, 3] - target)
    if size == 2:
        angle = Rotation.from_matrix(pose[:3, :3]).as_euler("zyx")[0]
        turn = abs(np.angle(np.exp(1j * (angle - np.ravel(target)[-1]))))
        return turn if kind == "orientation" else turn + np.linalg.norm(pose[:2, 3] - target[:2])
    turn = Rotation.from_matrix(target[:3, :3].T @ pose[:3, :3]).magnitude()
    return turn if kind == "orientation" else turn + np.linalg.norm(pose[:3, 3] - target[:3, 3])


def inside(robot, q):
    return bool((q >= robot.lower - 1e-9).all() and (q <= robot.upper + 1e-9).all())
