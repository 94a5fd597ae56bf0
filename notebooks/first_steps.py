# ---
# jupyter:
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # First steps
#
# A robot, a task, a criterion, and the result of a solve.
#
# Five revolute joints move the tip of a planar arm, and a position task has two rows. Three degrees of freedom are
# redundant. This library resolves that redundancy: it uses them to minimise criteria.

# %%
import matplotlib.pyplot as plt
import numpy as np

import jtik
from jtik.plotting.planar import draw_base, draw_obstacles, draw_postures
from jtik_formulations import JointCentering, ObstacleAvoidance

# %% [markdown]
# ## Robot and task
#
# A robot is an immutable tree of joints with limits. `Robot.builtin("panda")`, `Robot.from_urdf(...)` and
# `Robot.from_mjcf(...)` load real robots. A planar arm is stretched along x at q = 0.

# %%
arm = jtik.Robot.planar([1.0, 1.0, 0.8, 0.6, 0.4], lower=-2.5, upper=2.5)  # lengths [m], limits [rad]
task = jtik.FrameTask("tip", kind="position")
arm

# %% [markdown]
# ## Solve
#
# Building a solver compiles one step of the strategy, here the default `"hybrid"`. Targets are inputs of that step.

# %%
target, start = [1.6, 1.4], [1.2, 0.8, -0.4, -0.6, 0.5]  # [m], [rad]
ik = jtik.InverseKinematics(arm, task)
without_criterion = ik.solve(target, q0=start)
without_criterion

# %% [markdown]
# The first line is the status as a sentence. `solve` does not raise if a target cannot be reached; the status says why
# it stopped. This target is beyond the arm's length of 3.8 m:

# %%
ik.solve([5.0, 0.0], q0=start)

# %% [markdown]
# ## A criterion
#
# A criterion is a function H(q) that is minimised in the null space of the task. Criteria can be added and scaled. Here
# joint centering attracts every joint to zero, and obstacle avoidance repels the joints and the tip from a disc.

# %%
disc = jtik.Circle(center=(0.75, 1.0), radius=0.25)  # [m]
criteria = 1.0 * JointCentering() + 0.5 * ObstacleAvoidance([disc])
ik = jtik.InverseKinematics(arm, task, criteria=criteria)
solution = ik.solve(target, q0=start, trace=True)
solution

# %% [markdown]
# *Converged* now means that the tip is on target and H is stationary on it. The null-space residual is the norm of (I −
# J⁺J)∇H, the projection of the gradient of H onto the null space. If it is zero, H is stationary. Second derivatives
# show whether it is a minimum:

# %%
print("second order:       ", solution.second_order)
print("H, term by term:    ", {name: round(value, 4) for name, value in solution.criteria.items()})
print("null-space residual:", f"{solution.null_space_residual:.1e}")
print("without criterion H would be", round(ik.solve(target, q0=without_criterion.q, max_iterations=0).cost, 4))

# %% [markdown]
# The last line uses `max_iterations=0`, which only evaluates a configuration.
#
# ## Live parameters
#
# Weights, gains, preferred angles and obstacles are inputs of the compiled step. A change needs no compilation.

# %%
print(ik.parameters)

# %%
ik.parameters["obstacle_avoidance.weight"] = 3.0
weighted = ik.solve(target, q0=start)
ik.parameters["obstacle_avoidance.weight"] = 0.5
print(weighted)

# %% [markdown]
# ## A real robot
#
# Only the first lines change for a real robot, which includes its joint limits. `restarts` tries other starts if the
# first one does not lead to the target.

# %%
panda = jtik.Robot.builtin("panda")
panda_ik = jtik.InverseKinematics(panda, jtik.FrameTask("panda_hand_tcp", kind="pose"), criteria=JointCentering())
goal = panda.pose(panda.random_configuration(3))
panda_ik.solve(goal, q0=panda.keyframes["home"], restarts=20)

# %% [markdown]
# ## The trace
#
# With `trace=True` a Solution stores every iteration: q, the error, and figures such as V = ½ eᵀKp e, H, the step
# lengths and the smallest singular value of J. (The first trace takes longer, because it compiles a step that records.)

# %%
trace = solution.trace
print(len(trace), "iterations;", ", ".join(trace.figures))

# %% [markdown]
# The left figure shows two configurations with the same tip position: without a criterion the arm passes through the
# disc, with the criterion it avoids it. The right figure shows the iterations of the second solve. The first steps move
# the tip close to the target, and H rises. Then H decreases along the self-motion until its projected gradient
# vanishes. The solve ends when both lines are below the tolerance.

# %%
figure = plt.figure(figsize=(11, 5), layout="constrained")
left, right = figure.subfigures(1, 2, width_ratios=[1, 1.1])
axes = left.subplots()
axes.set(xlim=(-1.0, 2.2), ylim=(-0.2, 3.9), aspect="equal", xlabel="x [m]", ylabel="y [m]")
draw_obstacles(axes, [disc])
draw_postures(axes, arm, [start, without_criterion.q, solution.q], width=0.06)
draw_base(axes, size=0.06)
axes.plot(*target, "x", color="black", markersize=10, markeredgewidth=2, zorder=6)
axes.set_title("light: start; middle: no criterion; dark: with criterion", fontsize=10, loc="left")

top, bottom = right.subplots(2, 1, sharex=True)
top.semilogy(trace.error, color="#0072b2", label="task error [m]")
top.semilogy(
    np.append(trace.null_residual, solution.null_space_residual),
    "--",
    color="#d55e00",
    label="null-space residual [H/rad]",
)
top.axhline(1e-6, color="gray", linestyle=":", label="tolerance of the error")
top.legend(frameon=False)
bottom.plot(np.append(trace.H, solution.cost), color="#0072b2")
bottom.set(xlabel="iteration", ylabel="criterion H")
for axes in (top, bottom):
    axes.grid(alpha=0.3)
