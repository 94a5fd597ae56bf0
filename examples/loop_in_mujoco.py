"""A loop of 500 Hz that moves a simulated Panda in MuJoCo along a circle, within velocity and acceleration limits."""

import time

import mujoco
import numpy as np

import jtik
from jtik.interop.mink import to_mujoco

DT = 0.002  # [s]
panda = jtik.Robot.builtin("panda")
ik = jtik.InverseKinematics(
    panda, jtik.FrameTask("tip", kind="pose"), limits=jtik.Limits(velocity=1.5, acceleration=10.0)
)
ik.warm_up()

model = to_mujoco(panda)
model.opt.timestep = DT
data = mujoco.MjData(model)
q = panda.keyframes["home"].copy()
data.qpos[:] = q
pose, times, worst = panda.pose(q), [], 0.0
center = pose[:3, 3].copy()
for k in range(1500):
    angle = np.pi * (1 - np.cos(np.pi * k / 1500))  # starts and ends at rest
    pose[:3, 3] = center + 0.1 * np.array([np.cos(angle) - 1, np.sin(angle), 0.0])
    begin = time.perf_counter()
    step = ik.step(q, pose, dt=DT)
    times.append(time.perf_counter() - begin)
    velocity, q = (step.q - q) / DT, step.q
    data.qvel[:] = velocity  # a stiff servo: the arm has the commanded velocity
    mujoco.mj_integratePos(model, data.qpos, data.qvel, DT)
    worst = max(worst, float(np.linalg.norm(panda.position(data.qpos) - pose[:3, 3])))

print(f"largest error {1e3 * worst:.1g} mm; a step takes {1e6 * np.median(times):.0f} of {1e6 * DT:.0f} µs")
assert worst < 1e-3
