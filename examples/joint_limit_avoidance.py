"""The same path with and without a criterion for joint limits: how near the joints come to them."""

import numpy as np

import jtik
from jtik_formulations import LimitBarrier

arm = jtik.Robot.planar(5, lower=-1.5, upper=1.5)
start = np.array([1.2, -0.9, -0.8, 0.4, 0.6])
angle = np.linspace(0, 2 * np.pi, 100)
path = arm.position(start) + 0.8 * np.stack([np.cos(angle) - 1, np.sin(angle)], axis=1)

for name, criterion in {"without": None, "with": LimitBarrier()}.items():
    ik = jtik.InverseKinematics(arm, jtik.FrameTask("tip", kind="position"), criteria=criterion)
    motion = ik.track(path, q0=start, dt=0.05)
    margin = np.minimum(motion.q - arm.lower, arm.upper - motion.q).min(axis=1)
    print(f"{name}: {motion}; the nearest limit is {margin.min():.2f} rad away, {margin[-1]:.2f} rad at the end")
