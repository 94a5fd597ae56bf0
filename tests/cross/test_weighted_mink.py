"""The QP of weighted_qp is that of mink and pink: the same step for the same costs, limits and damping."""

from __future__ import annotations

import mink
import mujoco
import numpy as np
import pytest

import jtik
from jtik_formulations import JointCentering, WeightedQP

from ..conftest import shared_solver
from .test_mink import ARM, Position

SAME = 1e-8
"""DAQP twice on QPs of condition 1e5, built by different arithmetic."""

LIMITED = ARM.replace("<joint ", '<joint range="-1.2 1.2" ').replace("<mujoco>", '<mujoco><compiler angle="radian"/>')

OPTIONS = {"gain": 0.7, "lm_damping": 0.3, "damping": 1e-4, "weight": 0.05**2, "backtracking": False}
"""What follows is the same in their words."""

SPEED, DT = 3.0, 0.05

URDF = """
<robot name="arm"><link name="base"/>{links}
<joint name="fixed" type="fixed"><parent link="l4"/><child link="tip"/><origin xyz="0.2 0 0.1" rpy="0.3 0 0.2"/></joint>
<link name="tip"/></robot>
"""
LINK = """<link name="l{i}"/><joint name="j{i}" type="revolute"><parent link="{parent}"/><child link="l{i}"/>
<origin xyz="{xyz}" rpy="0 0 0"/><axis xyz="{axis}"/><limit lower="-1.2" upper="1.2" velocity="3.0" effort="1"/></joint>
"""
PLACES = ["0 0 0.3", "0.1 0 0.1", "0.4 0 0", "0.3 0.1 0"]
AXES = ["0 0 1", "0 1 0", "0 1 0", "1 0 0"]


def configurations(rng, n, count=20):
    """Generic ones, and ones where many joints are at a limit."""
    for k in range(count):
        yield rng.uniform(-1, 1, n) if k % 2 else rng.choice([-1.2, 0.0, 1.2], n)


def test_a_step_is_minks(rng):
    """Position and orientation with costs of their own, a posture task, position and velocity limits, both dampings."""
    model = mujoco.MjModel.from_xml_string(LIMITED)
    robot = jtik.Robot.from_mujoco(model)
    tasks = [
        jtik.FrameTask("tip", "position", stiffness=2.0**2, name="place"),
        jtik.FrameTask("tip", "orientation", stiffness=0.3**2, name="turn"),
    ]
    strategy = WeightedQP(q_limit=SPEED * DT, **OPTIONS)
    ik = shared_solver(robot, tasks, criteria=JointCentering(), strategy=strategy)
    limits = [
        mink.ConfigurationLimit(model, gain=1.0),
        mink.VelocityLimit(model, {f"j{i}": SPEED for i in range(1, 7)}),
    ]
    active = 0
    for q in configurations(rng, 6):
        configuration = mink.Configuration(model, q)
        goal = robot.pose(np.clip(q + rng.uniform(-0.3, 0.3, 6), -1.2, 1.2))
        place = Position("tip", goal[:3, 3])
        place.cost, place.gain, place.lm_damping = np.full(3, 2.0), OPTIONS["gain"], OPTIONS["lm_damping"]
        turn = mink.FrameTask("tip", "body", 0.0, 0.3, gain=OPTIONS["gain"], lm_damping=OPTIONS["lm_damping"])
        turn.set_target(mink.SE3.from_matrix(goal))
        posture = mink.PostureTask(model, cost=0.05)
        preferred = rng.uniform(-1, 1, 6)
        posture.set_target(preferred)
        velocity = mink.solve_ik(
            configuration, [place, turn, posture], DT, "daqp", damping=OPTIONS["damping"], limits=limits
        )
        ik.parameters["joint_centering.preferred"] = preferred
        ik.reset()
        dq = ik.step(q, {"place": goal, "turn": goal}).q - q
        assert dq == pytest.approx(velocity * DT, abs=SAME)
        active += int((np.abs(np.abs(velocity) - SPEED) < 1e-6).sum())
    assert active  # some joints were as fast as they may be


@pytest.mark.slow
def test_with_the_logarithm_as_error_a_step_is_that_of_minks_own_frame_task(rng):
    """A whole pose, with the task that a user of mink writes; with separate errors the step is another one."""
    model = mujoco.MjModel.from_xml_string(LIMITED)
    robot, apart = jtik.Robot.from_mujoco(model), {"logarithm": [], "separate": []}
    theirs = mink.FrameTask("tip", "body", 2.0, 0.3, gain=OPTIONS["gain"], lm_damping=OPTIONS["lm_damping"])
    limits = [mink.ConfigurationLimit(model, gain=1.0)]
    for error, differences in apart.items():
        task = jtik.FrameTask("tip", "pose", stiffness=[2.0**2] * 3 + [0.3**2] * 3, error=error)
        ik = shared_solver(robot, task, strategy=WeightedQP(q_limit=np.inf, **OPTIONS))
        for q in configurations(rng, 6):
            goal = robot.pose(np.clip(q + rng.uniform(-0.3, 0.3, 6), -1.2, 1.2))
            theirs.set_target(mink.SE3.from_matrix(goal))
            configuration = mink.Configuration(model, q)
            velocity = mink.solve_ik(configuration, [theirs], 1.0, "daqp", damping=OPTIONS["damping"], limits=limits)
            ik.reset()
            differences.append(np.abs(ik.step(q, goal).q - q - velocity).max())
    assert max(apart["logarithm"]) < SAME
    assert np.median(apart["separate"]) > 1e-3


def test_a_step_is_pinks(rng):
    """On Pinocchio's kinematics."""
    pytest.importorskip("pink")
    import pink
    import pinocchio
    from pink.limits import ConfigurationLimit, VelocityLimit

    links = "".join(
        LINK.format(i=i + 1, parent=f"l{i}" if i else "base", xyz=PLACES[i], axis=AXES[i]) for i in range(4)
    )
    text = URDF.format(links=links)
    model = pinocchio.buildModelFromXML(text)
    robot = jtik.Robot.from_urdf(text)
    strategy = WeightedQP(q_limit=SPEED * DT, **OPTIONS)
    task = jtik.FrameTask("tip", "position", stiffness=2.0**2)
    ik = shared_solver(robot, task, criteria=JointCentering(), strategy=strategy)

    class Place(pink.tasks.Task):
        """The world position of the frame "tip"."""

        def __init__(self, target):
            super().__init__(cost=[2.0] * 3, gain=OPTIONS["gain"], lm_damping=OPTIONS["lm_damping"])
            self.target = target

        def compute_error(self, configuration):
            return configuration.get_transform_frame_to_world("tip").translation - self.target

        def compute_jacobian(self, configuration):
            R = configuration.get_transform_frame_to_world("tip").rotation
            return R @ configuration.get_frame_jacobian("tip")[:3]

        def __repr__(self):
            return "Place"

    limits = [ConfigurationLimit(model, config_limit_gain=1.0), VelocityLimit(model)]
    for q in configurations(rng, 4):
        configuration = pink.Configuration(model, model.createData(), q)
        target = robot.position(np.clip(q + rng.uniform(-0.3, 0.3, 4), -1.2, 1.2))
        posture = pink.tasks.PostureTask(cost=0.05)
        preferred = rng.uniform(-1, 1, 4)
        posture.set_target(preferred)
        velocity = pink.solve_ik(
            configuration, [Place(target), posture], DT, solver="daqp", damping=OPTIONS["damping"], limits=limits
        )
        ik.parameters["joint_centering.preferred"] = preferred
        ik.reset()
        assert ik.step(q, target).q - q == pytest.approx(velocity * DT, abs=SAME)
