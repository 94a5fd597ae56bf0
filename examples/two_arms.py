"""Two arms on a torso carry a rod: one hand goes to a target, the other keeps its place beside it."""

import numpy as np

import jtik
from jtik import Joint, JointType
from jtik_formulations import JointCentering


def at(x=0.0, y=0.0, z=0.0):
    pose = np.eye(4)
    pose[:3, 3] = [x, y, z]
    return pose


axes = {"yaw": [0, 0, 1], "pitch": [0, 1, 0], "roll": [1, 0, 0]}
joints = [Joint("waist", JointType.REVOLUTE, "base", "torso", origin=at(z=0.8), axis=axes["yaw"])]
for side, y in (("left", 0.2), ("right", -0.2)):
    parent, origin = "torso", at(y=y, z=0.4)
    for name, axis, length in (
        ("shoulder_yaw", "yaw", 0.0),
        ("shoulder_pitch", "pitch", 0.0),
        ("shoulder_roll", "roll", 0.3),
        ("elbow", "pitch", 0.25),
        ("wrist_roll", "roll", 0.0),
        ("wrist_pitch", "pitch", 0.0),
        ("wrist_yaw", "yaw", 0.1),
    ):
        child = f"{side}_{name}"
        joints.append(Joint(child, JointType.REVOLUTE, parent, f"{child}_link", origin=origin, axis=axes[axis]))
        parent, origin = f"{child}_link", at(x=length)
    joints.append(Joint(f"{side}_grip", JointType.FIXED, parent, f"{side}_hand", origin=origin))

robot = jtik.Robot(joints, name="two_arms")
tasks = [
    jtik.FrameTask("left_hand", kind="position", name="left"),
    jtik.RelativeFrameTask("right_hand", "left_hand", kind="pose", name="rod"),
]
ik = jtik.InverseKinematics(robot, tasks, criteria=0.1 * JointCentering(preferred=[0.4] * robot.nq))
solution = ik.solve({"left": [0.45, 0.2, 1.1], "rod": at(y=-0.35)}, q0=[0.4] * robot.nq, restarts=20)
print(solution)
offset = np.linalg.inv(robot.pose(solution.q, "left_hand")) @ robot.pose(solution.q, "right_hand")
np.testing.assert_allclose(offset, at(y=-0.35), atol=1e-5)
