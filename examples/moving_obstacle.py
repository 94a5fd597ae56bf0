"""A control loop beside an obstacle that moves: its centre is a live parameter."""

import numpy as np

import jtik
from jtik_formulations import ObstacleAvoidance

arm = jtik.Robot.planar(6)
obstacle = jtik.Circle((3.0, 2.5), 0.4)
links = ObstacleAvoidance([obstacle], bodies="links")
ik = jtik.InverseKinematics(
    arm,
    jtik.FrameTask("tip", kind="position"),
    strategy="hybrid+qp",
    clearances=jtik.Clearance(links, safe=0.1),
)
ik.warm_up()

q = np.array([1.2, -0.5, -0.5, -0.4, -0.3, -0.2])
target = arm.position(q)
nearest, worst = np.inf, 0.0
for step in range(500):
    center = np.array([3.0, 2.5 - 0.004 * step])  # [m], downwards at 0.2 m/s
    ik.parameters["clearance.centers"] = [center]
    q = ik.step(q, target, dt=0.02).q
    points = np.array([arm.position(q, frame) for frame in (arm.base, *arm.moving_frames)])
    between = points[:-1, None] + np.linspace(0, 1, 50)[:, None] * np.diff(points, axis=0)[:, None]
    nearest = min(nearest, float(np.linalg.norm(between - center, axis=-1).min()) - obstacle.radius)
    worst = max(worst, float(np.linalg.norm(arm.position(q) - target)))

print(f"the links kept {nearest:.3f} m of 0.1 m, while the end effector moved {1e3 * worst:.3f} mm")
