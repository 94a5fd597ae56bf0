"""Turn the elbow of a Panda while its hand stays where it is, by one live number."""

import numpy as np

import jtik
from jtik_formulations import SwivelAngle

panda = jtik.Robot.builtin("panda")
swivel = SwivelAngle("panda_link2", "panda_link4", "panda_link6")
ik = jtik.InverseKinematics(panda, jtik.FrameTask("tip", kind="pose"), criteria=swivel)

hand = panda.pose(panda.home)
q = panda.home
for angle in np.linspace(-1.0, 1.0, 5):  # [rad]
    ik.parameters["swivel_angle.angle"] = angle
    solution = ik.solve(hand, q0=q)
    q = solution.q
    elbow = panda.position(q, "panda_link4")
    print(f"{angle:+.1f} rad: elbow at {elbow.round(3)}, hand off by {solution.position_error:.1e} m")
    assert solution.status.on_target
