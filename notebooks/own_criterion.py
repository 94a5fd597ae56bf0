# ---
# jupyter:
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # Plug in your own criterion
#
# A criterion is a function of q that CasADi can trace. Its derivatives are computed automatically, its keyword
# arguments are live parameters, and it works with every strategy.
#
# In this example a Panda holds a tool at a fixed pose, a task with six rows. Seven joints leave one redundant degree of
# freedom, along which the elbow moves. The criterion sets the height of the elbow.

# %%
import casadi
import matplotlib.pyplot as plt
import numpy as np

import jtik
from jtik.testing import check_criterion
from jtik_formulations import JointCentering

panda = jtik.Robot.builtin("panda")
tool = jtik.FrameTask("panda_hand_tcp", kind="pose")
start = panda.keyframes["home"] + [0.5, 0.1, -0.3, 0.3, 0.3, 0.1, 0.0]  # [rad]
pose = panda.pose(start)  # the tool stays here

# %% [markdown]
# ## Write it
#
# `q` is the configuration as an expression. `robot` gives positions, poses and Jacobians of any frame. An argument
# after the asterisk is a live parameter with its initial value.


# %%
@jtik.criterion
def elbow_height(q, robot, *, height=0.6):
    """Squared distance of the elbow from a height [m]; H in [m^2]."""
    return (robot.position(q, "panda_link4")[2] - height) ** 2


# %% [markdown]
# ## Check it
#
# `check_criterion` checks the contract of a criterion: it is one scalar, finite everywhere, its gradient agrees with
# finite differences, every parameter has an effect, and a solve with it ends. Use it in your tests. It returns None if
# all checks pass.

# %%
check_criterion(elbow_height, panda)

# %% [markdown]
# A function that cannot be traced is refused when the solver is built, with the line number. A Python `if` on an
# expression is the usual mistake. Use `casadi.if_else`, `casadi.fmax` and NumPy's functions instead.


# %%
@jtik.criterion
def only_above(q, robot, *, height=0.6):
    z = robot.position(q, "panda_link4")[2]
    return (z - height) ** 2 if z > height else 0.0


try:
    jtik.InverseKinematics(panda, tool, criteria=only_above)
except jtik.CriterionError as error:
    print(error)


# %%
@jtik.criterion
def only_above(q, robot, *, height=0.6):
    """No more than the height [m]: the squared distance above it."""
    return casadi.fmax(robot.position(q, "panda_link4")[2] - height, 0) ** 2


check_criterion(only_above, panda)

# %% [markdown]
# ## Use it
#
# It is used like any other criterion. A small weight on joint centering makes the minimum unique.

# %%
ik = jtik.InverseKinematics(panda, tool, criteria=elbow_height + 1e-5 * JointCentering())
solution = ik.solve(pose, q0=start)
print(solution)
print(f"elbow at {panda.position(solution.q, 'panda_link4')[2]:.3f} m")

# %% [markdown]
# ## Change it while it runs
#
# The parameters are inputs of the compiled step. A sweep over forty heights needs no compilation. Every solve starts
# from the previous solution.

# %%
print(ik.parameters)

# %%
requested = np.linspace(0.1, 0.75, 40)  # [m]
postures = []
for height in requested:
    ik.parameters["elbow_height.height"] = height
    solution = ik.solve(pose, q0=solution.q if postures else start)
    postures.append(solution.q)
    assert solution.converged, solution
    assert not solution.active_limits, solution
reached = np.array([panda.position(q, "panda_link4")[2] for q in postures])

# %% [markdown]
# ## Any strategy
#
# A criterion is independent of the strategy. The Newton step on the criterion (`+second_order`) also takes its second
# derivatives from CasADi.

# %%
ik.parameters["elbow_height.height"] = 0.5
for strategy in ("hybrid", "newton", "hybrid+qp", "hybrid+second_order", "mink"):
    other = jtik.InverseKinematics(panda, tool, criteria=elbow_height(height=0.5), strategy=strategy)
    found = other.solve(pose, q0=start)
    elbow = panda.position(found.q, "panda_link4")[2]
    print(f"{strategy:20} {found.status.name:10} {found.iterations:3} iterations, elbow at {elbow:.6f} m")

# %% [markdown]
# ## Its effect on the posture
#
# Left: the tool keeps its pose while the elbow moves to the requested heights. Right: requested and reached heights.
# Between 0.36 m and 0.64 m the self-motion passes through every height, and H falls to zero. The flat ends are the
# lowest and the highest elbow position for this pose of the tool. H is not zero there, and the solver ends at its
# minimum. No joint is at a limit.

# %%
figure, (front, axes) = plt.subplots(1, 2, figsize=(11, 5), layout="constrained", width_ratios=[1, 1.3])
colors = plt.colormaps["viridis"](np.linspace(0, 0.9, len(requested)))
frames = [panda.base, *panda.moving_frames]
for q, color in list(zip(postures, colors, strict=True))[::4]:
    y, z = np.array([panda.position(q, frame)[1:] for frame in frames]).T
    front.plot(y, z, color=color, linewidth=3, solid_joinstyle="round")
    front.plot(*panda.position(q, "panda_link4")[1:], "o", color=color, markersize=9, markeredgecolor="white")
front.plot(*pose[1:3, 3], "kx", markersize=10, markeredgewidth=2)
front.set(xlabel="y [m]", ylabel="z [m]", aspect="equal", title="front view: dots are elbows, the cross is the tool")

axes.plot(requested, requested, ":", color="gray", label="requested")
axes.scatter(requested, reached, c=colors, zorder=3, label="reached")
axes.set(xlabel="requested height [m]", ylabel="elbow height [m]")
axes.legend(frameon=False)
axes.grid(alpha=0.3)
