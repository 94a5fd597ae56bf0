"""Reach a pose with a Panda, and read what the solution says."""

import jtik

panda = jtik.Robot.builtin("panda")
ik = jtik.InverseKinematics(panda, jtik.FrameTask("tip", kind="pose"))

goal = panda.pose(panda.keyframes["home"])  # (4, 4); the tool points down
goal[:3, 3] = [0.45, 0.2, 0.4]  # [m]
solution = ik.solve(goal, restarts=20)
print(solution)

too_far = goal.copy()
too_far[:3, 3] = [1.2, 0.0, 0.4]
print(ik.solve(too_far))
