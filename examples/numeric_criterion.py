"""A criterion that CasADi cannot trace: a table of measured comfort, interpolated by NumPy."""

import numpy as np

import jtik

angles = np.linspace(-np.pi, np.pi, 25)  # [rad]
comfort = np.cos(angles - 0.6)  # as if measured, of the second joint


@jtik.criterion(numeric=True)
def discomfort(q):
    """Smooth between the samples: a sum of bumps around the measured angles."""
    weight = np.exp(-(((q[1] - angles) / 0.3) ** 2))
    return -float(weight @ comfort / weight.sum())


arm = jtik.Robot.planar(4)
ik = jtik.InverseKinematics(arm, jtik.FrameTask("tip", kind="position"), criteria=discomfort)
solution = ik.solve([2.0, 1.5], q0=[0.3, -0.4, 0.5, 0.2])
print(solution)
print(f"the second joint is at {solution.q[1]:.3f} rad, most comfortable at 0.6")
assert abs(solution.q[1] - 0.6) < 0.05
