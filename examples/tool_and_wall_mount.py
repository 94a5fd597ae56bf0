"""A tool of 0.2 m and 0.8 kg, and a robot on a wall."""

import numpy as np

import jtik

tool = np.eye(4)
tool[2, 3] = 0.2  # [m] along the z axis of the flange
wall = np.array(
    [[0, 0, 1, 0.0], [0, 1, 0, 0.0], [-1, 0, 0, 1.5], [0, 0, 0, 1]]
)  # z of the base points along x, 1.5 m up

arm = jtik.Robot.builtin("ur5e").with_tool(tool, name="gripper", mass=0.8).with_base(wall)
print(arm, "tip:", arm.tip)
ik = jtik.InverseKinematics(arm, jtik.FrameTask("gripper", kind="pose"))

goal = np.eye(4)
goal[:3, 3] = [0.6, 0.2, 1.3]
solution = ik.solve(goal, restarts=50)
print(solution)
np.testing.assert_allclose(arm.pose(solution.q, "gripper"), goal, atol=1e-5)
