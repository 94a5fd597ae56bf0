"""A humanoid reaches down: the feet stay where they are, the centre of mass stays over them."""

try:
    from importlib import metadata

    package = metadata.distribution("example-robot-data")  # a URDF of TALOS
except ImportError:
    raise SystemExit("This example needs example-robot-data: python -m pip install 'jtik[robots]'") from None
try:
    import matplotlib  # noqa: F401
except ImportError:
    raise SystemExit("This example needs matplotlib: python -m pip install 'jtik[plot]'") from None

from pathlib import Path

import numpy as np

import jtik
from jtik_formulations import JointCentering

urdf = next(Path(package.locate_file(file)) for file in package.files if file.name == "talos_reduced.urdf")
robot = jtik.Robot.from_urdf(urdf, free_base=True)
hand, feet = "gripper_right_base_link", ("left_sole_link", "right_sole_link")
bent = {f"leg_{side}_{k}_joint": angle for side in ("left", "right") for k, angle in ((3, -0.4), (4, 0.8), (5, -0.4))}
bent |= {"arm_left_2_joint": 0.4, "arm_right_2_joint": -0.4, "arm_left_4_joint": -1.2, "arm_right_4_joint": -1.2}
standing = robot.home.copy()  # [x, y, z, quaternion, joints]
for joint, angle in bent.items():
    standing[robot.q_slice(joint)] = angle  # [rad]

tasks = [jtik.FrameTask(foot, kind="pose") for foot in feet]
tasks += [jtik.FrameTask(hand, kind="position"), jtik.CenterOfMassTask(axes="xy")]
ik = jtik.InverseKinematics(robot, tasks, criteria=JointCentering(preferred=standing), joints="all")

target = {foot: robot.pose(standing, foot) for foot in feet}
target[hand] = np.add(robot.position(standing, hand), [0.2, 0.1, -0.5])  # [m]
target["center_of_mass"] = robot.center_of_mass(standing)
solution = ik.solve(target, q0=standing)
print(f"{solution.status.value}; {solution.iterations} iterations")

moved = robot.center_of_mass(solution.q) - robot.center_of_mass(standing)
print("centre of mass moved by", moved.round(3), "m, the left foot by", end=" ")
print(f"{np.linalg.norm(robot.position(solution.q, feet[0]) - robot.position(standing, feet[0])):.1e} m")
robot.plot([standing, solution.q], width=5).savefig("humanoid.png", dpi=120)
assert solution.converged
assert np.linalg.norm(moved[:2]) < 1e-6
