"""A Panda on a vehicle: with weights the arm moves first, and the vehicle only as far as it has to."""

import numpy as np

import jtik

robot = jtik.Robot.builtin("vehicle_panda")
vehicle = robot.joint_names[:3]
print("joints of the vehicle:", *vehicle)
goal = np.add(robot.position(robot.home), [0.5, 0.2, 0.0])

for weight in (1.0, 20.0):
    ik = jtik.InverseKinematics(robot, jtik.FrameTask("tip"), weights=dict.fromkeys(vehicle, weight))
    solution = ik.solve(goal)
    moved = np.abs(solution.q - robot.home)
    print(
        f"weight {weight:g}: vehicle {moved[:3].round(3)}, arm up to {moved[3:].max():.2f} rad; {solution.status.value}"
    )
