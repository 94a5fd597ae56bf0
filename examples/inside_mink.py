"""A criterion of jtik as a task of mink: the hand stays, and the posture gets better."""

import mink

import jtik
from jtik.interop.mink import criterion_task, to_mujoco
from jtik_formulations import JointCentering

panda = jtik.Robot.builtin("panda")
model = to_mujoco(panda)
start = panda.keyframes["home"] + [0.5, 0.1, -0.3, 0.3, 0.3, 0.1, 0.0]
configuration = mink.Configuration(model, start)
hold = mink.FrameTask("tip", "body", position_cost=1.0, orientation_cost=1.0)
hold.set_target(mink.SE3.from_matrix(panda.pose(start)))
centre = criterion_task(JointCentering(preferred=panda.keyframes["home"]), panda, model, gain=0.5)

before = centre.value(configuration)
for _ in range(30):
    dq = mink.solve_ik(configuration=configuration, tasks=[centre], constraints=[hold], dt=1.0, solver="daqp")
    configuration.integrate_inplace(dq, 1.0)
print(f"H {before:.4f} -> {centre.value(configuration):.4f}")
assert centre.value(configuration) < before
