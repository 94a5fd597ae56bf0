"""Three strategies on the same hundred problems, as a table."""

import jtik
from jtik_formulations import JointCentering

arm = jtik.Robot.planar(5)
comparison = jtik.compare(
    arm,
    jtik.FrameTask("tip", kind="position"),
    strategies=["hybrid", "newton", "transpose"],
    criteria=0.1 * JointCentering(),
    count=100,
    until="stationary",
)
print(comparison)
