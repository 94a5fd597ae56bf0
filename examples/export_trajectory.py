"""Follow a path, and write the joint motion as a table that pandas and spreadsheets read."""

try:
    import pandas as pd
except ImportError:
    raise SystemExit("This example needs pandas: python -m pip install 'jtik[study]'") from None

import numpy as np

import jtik

panda = jtik.Robot.builtin("panda")
ik = jtik.InverseKinematics(panda, jtik.FrameTask("tip", kind="pose"))
start = panda.pose(panda.home)
path = []
for share in np.linspace(0, 1, 100):
    pose = start.copy()
    pose[:3, 3] += [0.0, 0.15 * np.sin(np.pi * share) ** 2, -0.1 * share]
    path.append(pose)

motion = ik.track(path, q0=panda.home, dt=0.02)
print(motion)
motion.save("motion.csv")
table = pd.read_csv("motion.csv", index_col="time")
print(table.iloc[[0, 50, 100], :4])
np.testing.assert_array_equal(table[panda.joint_names[0]].to_numpy()[1:], motion.q[:, 0])
