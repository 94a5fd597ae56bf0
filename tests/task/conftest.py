"""Robots of the task tests, one of them also as a MuJoCo model."""

from __future__ import annotations

import functools

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

import jtik
from jtik.robot import Mass

from ..conftest import ball_arm, dh_arm, floating_arm, planar, shared_solver

__all__ = [
    "ROBOTS",
    "ball_arm",
    "built",
    "dh_arm",
    "expected_error",
    "floating_arm",
    "planar",
    "solver",
    "two_arms",
    "two_arms_model",
    "weighed",
]

ROBOTS = {
    "dh5": lambda: dh_arm(5, 1),
    "dh7": lambda: dh_arm(7, 2),
    "ball": ball_arm,
    "floating": floating_arm,
}
"""In space; ball and floating have more configuration variables than velocities."""

TWO_ARMS = """
<mujoco><worldbody><body name="trunk" pos="0 0 1"><freejoint/><geom size=".1 .2" type="capsule" mass="20"/>
  <body name="left1" pos="0 .2 .3" quat=".9 .3 .2 .1"><joint axis="0 1 0"/><geom size=".05" pos=".1 0 0" mass="2"/>
   <body name="left2" pos=".3 0 0"><joint axis="0 0 1"/><geom size=".05" pos=".1 .02 0" mass="1.5"/>
    <body name="left3" pos=".25 0 .05"><joint axis="1 1 0"/><geom size=".04" mass="1"/>
     <body name="left" pos=".1 0 0" quat=".8 0 .6 0"><geom size=".03" mass=".5"/></body></body></body></body>
  <body name="right1" pos="0 -.2 .3"><joint axis="0 1 0"/><geom size=".05" pos=".1 0 0" mass="2"/>
   <body name="right2" pos=".3 0 0"><joint axis="0 0 1"/><geom size=".05" pos=".1 -.02 0" mass="1.5"/>
    <body name="right3" pos=".2 0 0"><joint axis="1 0 0" type="slide"/><geom size=".04" mass="1"/>
     <body name="right" pos=".1 0 0"><joint axis="1 0 1"/><geom size=".03" mass=".5"/></body></body></body></body>
  <body name="head" pos="0 0 .5"><joint axis="0 0 1"/><geom size=".1" mass="3"/>
   <body name="eye" pos=".1 .03 0" quat=".7071 0 .7071 0"><joint axis="1 0 0"/><geom size=".01" mass=".1"/>
  </body></body>
</body></worldbody></mujoco>
"""


def solver(robot, task):
    """All joints of the robot free and without limits, so that Jacobians have its n columns."""
    return shared_solver(robot, task, limits=False, joints="all")


@functools.cache
def built(robot, task, *arguments, **options):
    """A solver, cached by its robot and by ``task(*arguments, **options)``: building one takes long."""
    return solver(robot, task(*arguments, **options))


def expected_error(robot, kind, q, target):
    """World-axes position error and the rotation vector of R_target' R, from robot.pose and scipy."""
    pose = robot.pose(q)
    position = (pose - target)[: robot.dimension, 3]
    rotation = Rotation.from_matrix(target[:3, :3].T @ pose[:3, :3]).as_rotvec()
    rotation = rotation[2:] if robot.dimension == 2 else rotation
    return {"position": position, "orientation": rotation, "pose": np.concatenate([position, rotation])}[kind]


@functools.cache
def two_arms_model():
    return mujoco.MjModel.from_xml_string(TWO_ARMS)


@functools.cache
def two_arms():
    """The same tree from the arrays of the MuJoCo model: nq = 16, n = 15, both in MuJoCo's order."""
    model = two_arms_model()
    joints, masses = [], {}
    for body in range(1, model.nbody):
        name, parent = model.body(body).name, model.body(model.body_parentid[body]).name
        origin = np.eye(4)
        origin[:3, :3] = Rotation.from_quat(np.roll(model.body_quat[body], -1)).as_matrix()
        origin[:3, 3] = model.body_pos[body]
        kind, axis = jtik.JointType.FIXED, np.array([0.0, 0.0, 1.0])
        if model.body_jntnum[body]:
            number = model.body_jntadr[body]
            axis = model.jnt_axis[number]
            kind = {
                mujoco.mjtJoint.mjJNT_FREE: jtik.JointType.FREE,
                mujoco.mjtJoint.mjJNT_HINGE: jtik.JointType.REVOLUTE,
                mujoco.mjtJoint.mjJNT_SLIDE: jtik.JointType.PRISMATIC,
            }[mujoco.mjtJoint(model.jnt_type[number])]
        # the pose of a free body is the position of its joint
        origin = np.eye(4) if kind is jtik.JointType.FREE else origin
        joints.append(jtik.Joint(name, kind, parent, name, origin=origin, axis=axis))
        masses[name] = Mass(model.body_mass[body], model.body_ipos[body])
    return jtik.Robot(joints, name="two_arms", base="world", tip="left", masses=masses)


@functools.cache
def weighed():
    """A planar arm with a mass on each link."""
    arm = jtik.Robot.planar([0.5, 0.4, 0.3])
    masses = {f"link{k}": Mass(4 - k, (0.1 * k, 0.02, 0.3)) for k in (1, 2, 3)}
    return jtik.Robot(arm.joints, name="weighed", planar=True, masses=masses)
