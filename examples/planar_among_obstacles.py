"""A ten-link arm among obstacles: a posture for each of three targets, as a figure."""

try:
    import matplotlib  # noqa: F401
except ImportError:
    raise SystemExit("This example needs matplotlib: python -m pip install 'jtik[plot]'") from None

import jtik
from jtik.plotting import posture_figure
from jtik_formulations import JointCentering, ObstacleAvoidance

arm = jtik.Robot.planar(10)
field = [jtik.Circle((4.0, 2.0), 0.6), jtik.Circle((6.5, -1.0), 0.8), jtik.Circle((2.0, -1.5), 0.5)]
ik = jtik.InverseKinematics(
    arm,
    jtik.FrameTask("tip", kind="position"),
    criteria=JointCentering() + 0.3 * ObstacleAvoidance(field, bodies="links"),
)

q, postures = [0.1] * 10, []
for target in ([6.0, 3.0], [7.0, 2.0], [5.0, -2.5]):
    solution = ik.solve(target, q0=q)
    print(f"{target}: {solution.status.value}; H {solution.cost:.3f}")
    q = solution.q
    postures.append(q)

posture_figure(arm, postures, obstacles=field, width=7).savefig("planar_among_obstacles.png", dpi=120)
