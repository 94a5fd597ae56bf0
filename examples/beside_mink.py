"""The same problem with jtik and with mink: the same answer, and the times of both."""

import time

import mink
import numpy as np

import jtik
from jtik.interop.mink import to_mujoco

panda = jtik.Robot.builtin("panda")
start = panda.keyframes["home"] + 0.2
goal = panda.pose(panda.keyframes["home"])

ik = jtik.InverseKinematics(panda, jtik.FrameTask("tip", kind="pose"))
begin = time.perf_counter()
solution = ik.solve(goal, q0=start)
print(f"jtik: {solution.iterations} steps, error {solution.position_error:.1e} m, {time.perf_counter() - begin:.4f} s")

model = to_mujoco(panda)
configuration = mink.Configuration(model, start)
task = mink.FrameTask("tip", "body", position_cost=1.0, orientation_cost=1.0)
task.set_target(mink.SE3.from_matrix(goal))
limits = [mink.ConfigurationLimit(model)]
begin = time.perf_counter()
errors = []
while len(errors) < 100:
    dq = mink.solve_ik(configuration=configuration, tasks=[task], limits=limits, dt=1.0, solver="daqp", damping=1e-6)
    configuration.integrate_inplace(dq, 1.0)
    errors.append(np.abs(task.compute_error(configuration)).max())
    if errors[-1] < 1e-6:
        break
error = np.linalg.norm(panda.position(configuration.q) - goal[:3, 3])
print(f"mink: {len(errors)} steps, error {error:.1e} m, {time.perf_counter() - begin:.4f} s")
assert error < 1e-5
