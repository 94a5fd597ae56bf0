"""The null-space projection is the strict QP without inequalities: beside mink's, solved by DAQP."""

from __future__ import annotations

import math

import mink
import mujoco
import numpy as np
import pytest
import qpsolvers

import jtik
from jtik_formulations import JointCentering, Newton, ProjectedGradient

from ..conftest import dh_arm, planar, shared_solver

PLAIN = Newton(backtracking=False, q_limit=math.inf, secondary=ProjectedGradient(rule="paper"))
"""-J+ e - (I - J+ J) dH, with beta = 1."""

DAQP = 1e-6
"""DAQP's own tolerance, and mink's damping of 1e-12 over the smallest squared singular value."""

ARM = """
<mujoco><worldbody>
  <body><joint name="j1" axis="0 0 1"/><geom size=".01" mass="1"/>
  <body pos="0 0 .3"><joint name="j2" axis="0 1 0"/><geom size=".01" mass="1"/>
  <body pos=".4 0 0"><joint name="j3" axis="0 1 0"/><geom size=".01" mass="1"/>
  <body pos=".3 .1 0"><joint name="j4" axis="1 0 0"/><geom size=".01" mass="1"/>
  <body pos=".2 0 .1"><joint name="j5" axis="0 1 0"/><geom size=".01" mass="1"/>
  <body pos=".1 0 0"><joint name="j6" axis="0 0 1"/><geom size=".01" mass="1"/>
  <body name="tip" pos=".1 0 .2"><geom size=".01" mass="1"/></body>
  </body></body></body></body></body></body>
</worldbody></mujoco>
"""


class Position(mink.Task):
    """The world position of a body, on MuJoCo's kinematics."""

    def __init__(self, body, target):
        super().__init__(cost=np.ones(3), gain=1.0)
        self.body, self.target = body, target

    def compute_error(self, configuration):
        return configuration.data.body(self.body).xpos - self.target

    def compute_jacobian(self, configuration):
        jacobian = np.zeros((3, configuration.nv))
        identity = configuration.data.body(self.body).id
        mujoco.mj_jacBody(configuration.model, configuration.data, jacobian, None, identity)
        return jacobian


def test_newton_with_the_null_space_term_is_minks_strict_form(rng):
    model = mujoco.MjModel.from_xml_string(ARM)
    robot = jtik.Robot.from_mujoco(model) if hasattr(jtik.Robot, "from_mujoco") else _twin(model)
    ik = shared_solver(robot, jtik.FrameTask("tip"), criteria=JointCentering(), strategy=PLAIN, limits=False)
    for _ in range(10):
        q, preferred = rng.uniform(-1, 1, (2, 6))
        configuration = mink.Configuration(model, q)
        target = configuration.data.body("tip").xpos + rng.uniform(-0.1, 0.1, 3)
        posture = mink.PostureTask(model, cost=1.0)
        posture.set_target(preferred)
        velocity = mink.solve_ik(
            configuration, [posture], dt=1.0, solver="daqp", limits=[], constraints=[Position("tip", target)]
        )
        ik.parameters["joint_centering.preferred"] = preferred
        ik.reset()
        assert ik.step(q, target).q - q == pytest.approx(velocity, abs=DAQP)


def _twin(model):
    """The same arm built by hand."""
    joints, parent = [], "base"
    for body in range(1, model.nbody):
        origin = np.eye(4)
        origin[:3, 3] = model.body_pos[body]
        child = f"body{body}" if body < model.nbody - 1 else "tip"
        kind = jtik.JointType.REVOLUTE if body < model.nbody - 1 else jtik.JointType.FIXED
        axis = model.jnt_axis[body - 1] if body < model.nbody - 1 else np.array([0.0, 0.0, 1.0])
        joints.append(jtik.Joint(f"j{body}", kind, parent, child, origin=origin, axis=axis))
        parent = child
    return jtik.Robot(joints)


@pytest.mark.parametrize("name", ["planar", "pose"])
def test_the_same_step_is_the_equality_constrained_qp(name, rng):
    """min 1/2 |dq + dH|^2 subject to J dq = -e."""
    robot, kind = {"planar": (planar(10), "position"), "pose": (dh_arm(8, 1), "pose")}[name]
    ik = shared_solver(robot, jtik.FrameTask("tip", kind), criteria=JointCentering(), strategy=PLAIN, limits=False)
    for _ in range(10):
        q = rng.uniform(-1, 1, robot.n)
        target = robot.pose(q + rng.uniform(-0.1, 0.1, robot.n))
        seen = ik.solve(target, q0=q, max_iterations=0)
        best = qpsolvers.solve_qp(np.eye(robot.n), seen.gradient, A=seen.jacobian, b=-seen.error, solver="daqp")
        ik.reset()
        assert ik.step(q, target).q - q == pytest.approx(best, abs=DAQP)
