"""Manipulability along a path, without and with the criterion, as a figure."""

try:
    import matplotlib.pyplot as plt
except ImportError:
    raise SystemExit("This example needs matplotlib: python -m pip install 'jtik[plot]'") from None

import numpy as np

import jtik
from jtik_formulations import Manipulability

arm = jtik.Robot.planar([0.5, 0.4, 0.3, 0.2])
task = jtik.FrameTask("tip", kind="position")
angle = np.linspace(0, np.pi, 120)
path = np.stack([0.9 * np.cos(angle), 0.3 + 0.6 * np.sin(angle)], axis=1)
criterion = Manipulability(kind="position")

figure, axes = plt.subplots(figsize=(6, 3), layout="constrained")
for label, criteria in (("without", None), ("with", 0.05 * criterion)):
    ik = jtik.InverseKinematics(arm, task, criteria=criteria)
    q0 = ik.solve(path[0], q0=[0.2, 0.3, -0.4, 0.2]).q
    motion = ik.track(path, q0=q0, dt=0.02)
    w = [np.exp(-criterion(q, arm)) for q in motion.q]
    axes.plot(motion.times, w, label=label)
    print(f"{label}: smallest manipulability {min(w):.3f} m²")
axes.set_xlabel("time [s]")
axes.set_ylabel("manipulability [m²]")
axes.legend(frameon=False)
figure.savefig("manipulability_along_a_path.png", dpi=120)
