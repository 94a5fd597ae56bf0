"""Many targets at once.

python examples/batch.py [COUNT]        a million takes about a minute, compiled
"""

import sys

import numpy as np

import jtik
from jtik_formulations import Damped

panda = jtik.Robot.builtin("panda")
compiled = len(sys.argv) > 1  # needs a C compiler
ik = jtik.InverseKinematics(
    panda, jtik.FrameTask("tip", kind="pose"), strategy=Damped(backtracking=False), compiled=compiled
)
rng = np.random.default_rng(0)
goals = [panda.pose(panda.random_configuration(rng)) for _ in range(int(sys.argv[1]) if compiled else 500)]
batch = ik.solve_batch(goals, restarts=100)
print(batch)
print(f"median {1e6 * np.median(batch.seconds):.0f} µs a target")
