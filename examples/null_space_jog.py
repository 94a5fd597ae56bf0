"""Jog an arm through its null space: the elbow moves, the end effector stays, and the result says where it ends."""

import numpy as np

import jtik

panda = jtik.Robot.builtin("panda")
ik = jtik.InverseKinematics(panda, jtik.FrameTask("tip", kind="pose"))
start = panda.home
hand = panda.position(start)

q = start
for step in range(2000):  # 40 s at 0.02 s
    jog = ik.jog(q, 0.4, direction="panda_joint1")  # rad/s of the joint along the self-motion
    if jog.ended:
        print(f"after {0.02 * step:.1f} s: {jog.reason}")
        break
    q = jog.q
print("elbow moved by", np.round(panda.position(q, "panda_link4") - panda.position(start, "panda_link4"), 3), "m")
print(f"hand moved by {np.linalg.norm(panda.position(q) - hand):.1e} m")
assert np.linalg.norm(panda.position(q) - hand) < 1e-6

for _ in range(50):  # and back, with the opposite sign
    q = ik.jog(q, -0.4, direction="panda_joint1").q
print("first joint", round(float(q[0]), 3))
