"""Five joints cannot reach every pose: the position exactly, the orientation as near as possible."""

import jtik

arm = jtik.Robot.builtin("ur5e")
five = arm.joint_names[:5]  # the sixth is locked
tasks = [
    jtik.FrameTask("tip", kind="position", priority=0, name="position"),
    jtik.FrameTask("tip", kind="orientation", priority=1, name="orientation"),
]
ik = jtik.InverseKinematics(arm, tasks, strategy="lexicographic_qp", joints=five)

goal = arm.pose(arm.random_configuration(4))
solution = ik.solve({"position": goal[:3, 3], "orientation": goal[:3, :3]}, restarts=20)
print(solution)
assert solution.position_error < 1e-6
