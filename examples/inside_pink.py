"""A criterion of jtik as a task of pink: the hand stays, and the posture gets better."""

try:
    import pink
    import pinocchio
except ImportError:
    raise SystemExit("This example needs pink: python -m pip install 'jtik[pink]'") from None

import numpy as np

import jtik
from jtik.interop.pink import criterion_task
from jtik.interop.urdf import to_urdf
from jtik_formulations import JointCentering

panda = jtik.Robot.builtin("panda")
model = pinocchio.buildModelFromXML(to_urdf(panda))  # a model that you have will do as well
start = panda.keyframes["home"] + [0.5, 0.1, -0.3, 0.3, 0.3, 0.1, 0.0]
configuration = pink.Configuration(model, model.createData(), start)
hold = pink.FrameTask("tip", position_cost=1.0, orientation_cost=1.0)
hold.set_target_from_configuration(configuration)
centre = criterion_task(JointCentering(preferred=panda.keyframes["home"]), panda, model, gain=0.5)

hand, before = panda.position(start), centre.value(configuration)
for _ in range(30):
    velocity = pink.solve_ik(configuration, [centre], 1.0, solver="daqp", constraints=[hold], safety_break=False)
    configuration.integrate_inplace(velocity, 1.0)
print(f"H {before:.4f} -> {centre.value(configuration):.4f}")
print(f"the hand moved by {np.linalg.norm(panda.position(configuration.q) - hand):.1e} m")
assert centre.value(configuration) < before
