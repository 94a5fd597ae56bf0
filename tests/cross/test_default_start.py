"""From where a solve starts by default it reaches ordinary poses: those of configurations around home.

The arms of example-robot-data have no keyframes: their home is the neutral configuration away from its limits.
"""

from __future__ import annotations

from importlib import metadata
from pathlib import Path

import numpy as np
import pytest

import jtik
from jtik.robot import gallery

from ..conftest import shared_solver

NOISE = 0.5
"""Largest distance of each joint from home [rad] or [m]."""

POSES = 25

ARMS = {
    "panda.urdf": None,
    "talos_left_arm.urdf": None,
    "so100.urdf": None,
    "so101.urdf": None,
    "z1.urdf": None,
    "ur3_joint_limited_robot.urdf": None,
    "ur5_robot.urdf": None,
    "ur10_joint_limited_robot.urdf": None,
    "kinova.urdf": None,
    "xarm7.urdf": None,
    "baxter.urdf": "left_gripper",
    "tiago.urdf": "arm_tool_link",
    "tiago_pro.urdf": "arm_left_tool_link",
    "pr2.urdf": "r_gripper_tool_frame",
    "anymal-kinova.urdf": None,
    "b1-z1.urdf": None,
}
"""The arms of the package and arms of its mobile robots, one of each model, and their end effectors."""


def share_reached(robot):
    """The share of targets that a solve without q0 and without restarts reaches."""
    ik = shared_solver(robot, jtik.FrameTask(robot.tip, "position" if robot.dimension == 2 else "pose"))
    arm, rng = ik.robot, np.random.default_rng(13)
    target_at = arm.position if arm.dimension == 2 else arm.pose
    reached = 0
    for _ in range(POSES):
        q = arm.integrate(arm.home, rng.uniform(-NOISE, NOISE, arm.n))
        solution = ik.solve(target_at(np.clip(q, arm.lower, arm.upper)), max_iterations=100)
        reached += solution.converged
    return reached / POSES


@pytest.mark.quick(4)
@pytest.mark.parametrize("name", gallery.names())
def test_built_in_arms_reach_poses_around_home(name):
    assert share_reached(jtik.Robot.builtin(name)) >= 0.99


@pytest.mark.quick(3, slow=6)
@pytest.mark.filterwarnings("ignore:.*negative principal moment")  # TIAGo: antennas
@pytest.mark.filterwarnings("ignore:.*its limits, 0 to 0.548, are not kept")  # PR2: followers with the other sign
@pytest.mark.robots
@pytest.mark.parametrize("file", ARMS)
def test_arms_from_files_reach_poses_around_mid_range(file):
    pytest.importorskip("mujoco")
    try:
        package = metadata.distribution("example-robot-data")
    except metadata.PackageNotFoundError:
        pytest.skip("example-robot-data is not installed")
    path = next(Path(package.locate_file(path)) for path in package.files if path.name == file)
    assert share_reached(jtik.Robot.from_urdf(path, tip=ARMS[file])) >= 0.95
