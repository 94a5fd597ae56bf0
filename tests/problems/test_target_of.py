"""The target that a configuration meets, against the error that a solver reports for it."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik.problems.target_of import target_of

from ..conftest import planar, shared_solver
from .conftest import gallery, mujoco_pose

SPATIAL = [
    jtik.FrameTask(kind="position"),
    jtik.FrameTask(kind="orientation"),
    jtik.FrameTask(kind="pose"),
    jtik.RelativeFrameTask("tip", "forearm_link"),
    jtik.AxisTask("tip"),
    jtik.LookAtTask("tip"),
]
PLANAR = [jtik.FrameTask(kind="pose"), jtik.FrameTask(kind="orientation"), jtik.AxisTask("tip", (0.0, 1.0))]


@pytest.mark.quick(3)
@pytest.mark.parametrize(
    ("robot", "task"),
    [*((lambda: gallery("ur5e"), task) for task in SPATIAL), *((lambda: planar(3), task) for task in PLANAR)],
)
def test_the_configuration_is_on_its_target(robot, task):
    robot = robot()
    q = robot.random_configuration(3)
    ik = shared_solver(robot, task, joints="all")
    solution = ik.solve(target_of(task, robot, q), q0=q, max_iterations=0)
    assert np.abs(solution.error).max() < 1e-9


def test_the_target_of_a_pose_is_that_of_mujoco():
    robot = gallery("ur5e")
    q = robot.random_configuration(5)
    np.testing.assert_allclose(target_of(jtik.FrameTask(kind="pose"), robot, q), mujoco_pose(robot, q), atol=1e-9)
