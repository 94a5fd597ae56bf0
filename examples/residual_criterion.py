"""A criterion as a vector of residuals: H = 1/2 |r|^2, whose Gauss-Newton Hessian makes few steps of it."""

import casadi

import jtik


@jtik.criterion(residual=True)
def over_the_edge(q, robot, *, edge=(1.0, 1.2)):
    """The second link's end near a point [m], and a little of a straight wrist [rad]."""
    return casadi.vertcat(robot.position(q, "link2") - edge, 0.1 * q[-1])


arm = jtik.Robot.planar(6)
for strategy in ("hybrid", "hybrid+second_order"):
    ik = jtik.InverseKinematics(arm, jtik.FrameTask("tip"), criteria=over_the_edge, strategy=strategy)
    solution = ik.solve([3.0, 2.0], q0=[0.8, -0.2, -0.3, 0.1, 0.2, 0.3])
    print(f"{strategy}: {solution.iterations} iterations, H {solution.cost:.6f}")
    assert solution.converged
