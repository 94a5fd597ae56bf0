# ---
# jupyter:
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # Compare strategies
#
# Which update law is best depends on the robot, on the problems and on what you count. `jtik.compare` puts any number
# of strategies on the same problems, with the same starts and tolerances, and judges what they hand in by kinematics of
# its own.
#
# ## A ten-link arm
#
# Eight degrees of freedom are left over. Every strategy has to reach the target *and* to bring the joint centering
# criterion down until it is stationary. Half of the problems start near a singular posture.

# %%
import jtik
from jtik_formulations import Damped, JointCentering

arm = jtik.Robot.planar(10)
on_arm = jtik.compare(
    arm,
    jtik.FrameTask("tip", kind="position"),
    criteria=JointCentering(),
    strategies=["hybrid", "hybrid+second_order", "newton", "damped", "transpose", "transpose_bb", "sns", "mink"],
    problems={"reachable": 15, "near_singular": 15},
    until="stationary",
)
on_arm

# %% [markdown]
# A row is one strategy. Iterations, times and H are medians of the solved cases; `on_arm.table()` is the same in
# pandas. *Regret* is how far H ended above the best that anybody found for the same case: a strategy may converge to a
# local minimum of H, and then others show it. *Monotone* is the share of cases in which V never rose. It is low here:
# a step that lowers H may move the tip a little, and near the target these strategies weigh one against the other.
#
# Medians hide the hard cases. A performance profile (Dolan and Moré) does not: for every strategy it shows the share of
# cases that it solved within a factor of the best time for that case. On the left, who is often the fastest; on the
# right end, who solves the most.

# %%
on_arm.plot_profile()

# %% [markdown]
# Iterations tell another story than time: a step of one strategy may cost ten of another's.

# %%
on_arm.plot_profile(measure="iterations")

# %% [markdown]
# The error by iteration, median and middle half. The plateau is the phase in which the tip stays near the target while
# H falls.

# %%
on_arm.plot_convergence(contenders=["hybrid", "hybrid+second_order", "transpose", "transpose_bb"])

# %% [markdown]
# The criterion: as it falls in one case, and how far above the best of its case each strategy ended. What is left at
# the right edge are cases in which a strategy ended in another, worse minimum.

# %%
on_arm.plot_criteria()

# %% [markdown]
# The way of the arm in one case, from light to dark: strategies that end in the same minimum do not take the same way.

# %%
on_arm.plot_postures(contenders=["hybrid", "hybrid+second_order", "transpose", "mink"])

# %% [markdown]
# ## A Panda
#
# A pose in space, joint limits, no criterion: arrive. Each strategy has one attempt from one start, so that what it can
# do by itself is seen. A strategy may be a name, an object with options, or another library, `"peer:mink"`. One that
# does not exist, or is not installed, does not stop the study: its rows say so.

# %%
panda = jtik.Robot.builtin("panda")
on_panda = jtik.compare(
    panda,
    jtik.FrameTask("panda_hand_tcp", kind="pose"),
    strategies=["hybrid", "newton", Damped(damping=0.3), "sugihara", "sns", "weighted_qp", "peer:mink", "gauss"],
    problems={"reachable": 20, "near_singular": 10, "near_limits": 10},
    max_iterations=200,
)
on_panda

# %% [markdown]
# By kind of problem:

# %%
on_panda.table(by=("kind", "contender")).pivot(index="contender", columns="kind", values="success [%]")

# %% [markdown]
# Why the others failed. All rows, one a strategy and case, are a pandas frame; `to_csv`, `to_markdown`, `to_html` and
# `save` write them.

# %%
frame = on_panda.frame()
frame[~frame["success"]].groupby(["contender", "status"]).size()

# %% [markdown]
# ## With restarts
#
# In use, a failed attempt costs a restart and not the answer. The same problems again, with up to 50 other starts
# within the limits:

# %%
restarted = jtik.compare(
    panda,
    jtik.FrameTask("panda_hand_tcp", kind="pose"),
    strategies=["hybrid", "newton", Damped(damping=0.3), "sugihara", "sns", "weighted_qp"],
    problems=on_panda.problems,
    max_iterations=200,
    restarts=50,
)
restarted

# %% [markdown]
# What to take away: the profile starts with who is fast and ends with who arrives. With one attempt these were not the
# same strategies. With restarts nearly everything is solved, and what counts is how soon an attempt arrives or is given
# up.

# %%
restarted.plot_profile()
