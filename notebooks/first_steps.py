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
# A robot, a task, a criterion, and what a solve tells you.
#
# Five hinges move the tip of a planar arm, and a position is two numbers. Three degrees of freedom are left over, and
# the question this library is about is what to do with them.

# %%
import matplotlib.pyplot as plt
import numpy as np

import jtik
from jtik.plotting.planar import draw_base, draw_obstacles, draw_postures
from jtik_formulations import JointCentering, ObstacleAvoidance

# %% [markdown]
# ## Robot and task
#
# A robot is a tree of joints with limits; it cannot change. `Robot.builtin("panda")`, `Robot.from_urdf(...)` and
# `Robot.from_mjcf(...)` give real ones. A planar arm lies stretched along x at q = 0.

# %%
arm = jtik.Robot.planar([1.0, 1.0, 0.8, 0.6, 0.4], lower=-2.5, upper=2.5)  # lengths [m], limits [rad]
task = jtik.FrameTask("tip", kind="position")
arm

# %% [markdown]
# ## Solve
#
# Building a solver compiles one step of the strategy, here `"hybrid"`, the default. After that, targets are numbers.

# %%
target, start = [1.6, 1.4], [1.2, 0.8, -0.4, -0.6, 0.5]  # [m], [rad]
ik = jtik.InverseKinematics(arm, task)
plain = ik.solve(target, q0=start)
plain

# %% [markdown]
# The first line is the status, and it is a sentence. `solve` never raises because a target is hard: it says what
# happened. This target is farther away than the arm is long, 3.8 m:

# %%
ik.solve([5.0, 0.0], q0=start)

# %% [markdown]
# ## A criterion
#
# A criterion is a function H(q) that the freedom left over is to minimise. Criteria add and scale. Here springs pull
# every joint to zero, and a disc repels the joints and the tip.

# %%
disc = jtik.Circle(center=(0.75, 1.0), radius=0.25)  # [m]
criteria = 1.0 * JointCentering() + 0.5 * ObstacleAvoidance([disc])
ik = jtik.InverseKinematics(arm, task, criteria=criteria)
solution = ik.solve(target, q0=start, trace=True)
solution

# %% [markdown]
# *Converged* now means two things: the tip is on target, and H cannot fall further without leaving it. The null-space
# residual is the part of the gradient of H that the self-motions of the arm could still follow, the norm of
# (I − J⁺J)∇H. Where it is zero H is stationary; second derivatives tell whether it is a minimum there:

# %%
print("second order:       ", solution.second_order)
print("H, term by term:    ", {name: round(value, 4) for name, value in solution.criteria.items()})
print("null-space residual:", f"{solution.null_space_residual:.1e}")
print("without criterion H would be", round(ik.solve(target, q0=plain.q, max_iterations=0).cost, 4))

# %% [markdown]
# The last line used `max_iterations=0`, which evaluates a configuration and does not move.
#
# ## Live parameters
#
# Weights, gains, preferred angles, obstacles: they are all inputs of the compiled step. Changing one compiles nothing.

# %%
print(ik.parameters)

# %%
ik.parameters["obstacle_avoidance.weight"] = 3.0
wary = ik.solve(target, q0=start)
ik.parameters["obstacle_avoidance.weight"] = 0.5
print(wary)

# %% [markdown]
# ## A real robot
#
# A real robot changes only the first lines; limits come with it, and `restarts` tries other starts where the first one
# does not lead to the target.

# %%
panda = jtik.Robot.builtin("panda")
panda_ik = jtik.InverseKinematics(panda, jtik.FrameTask("panda_hand_tcp", kind="pose"), criteria=JointCentering())
goal = panda.pose(panda.random_configuration(3))
panda_ik.solve(goal, q0=panda.keyframes["home"], restarts=20)

# %% [markdown]
# ## The trace
#
# With `trace=True` a Solution keeps every iteration: q, the error, and figures such as V = ½ eᵀKp e, H, the step
# lengths and the smallest singular value of J. (The first trace takes longer: it compiles a step that records.)

# %%
trace = solution.trace
print(len(trace), "iterations;", ", ".join(trace.figures))

# %% [markdown]
# The picture to take away. On the left, two postures with the tip in the same place: the arm that was only told where
# the tip belongs runs through the disc, the other one goes round it. On the right, how the second one got there: the
# first steps bring the tip near, and H rises, since the comfortable start did not reach that far; then H falls along
# the self-motions until nothing is left of its gradient there. The solve ends when both lines are below the tolerance.

# %%
figure = plt.figure(figsize=(11, 5), layout="constrained")
left, right = figure.subfigures(1, 2, width_ratios=[1, 1.1])
axes = left.subplots()
axes.set(xlim=(-1.0, 2.2), ylim=(-0.2, 3.9), aspect="equal", xlabel="x [m]", ylabel="y [m]")
draw_obstacles(axes, [disc])
draw_postures(axes, arm, [start, plain.q, solution.q], width=0.06)
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
