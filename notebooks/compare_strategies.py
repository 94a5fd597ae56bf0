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
# The best strategy depends on the robot, the problems and the measure. `jtik.compare` runs any number of strategies on
# the same problems, with the same starts and tolerances. One independent check of the answers decides about success.
#
# ## A ten-link arm
#
# The arm has eight redundant degrees of freedom. Every strategy must reach the target *and* minimise the joint
# centering criterion until it is stationary. Half of the problems start close to a singular posture.

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
# Each row is one strategy. Iterations, times and H are medians over the solved cases; `on_arm.table()` is the same
# table in pandas. *Regret* is the difference between the final H and the best H of all strategies for the same case. It
# is positive if a strategy converges to a worse local minimum of H. *Monotone* is the share of cases in which V never
# rose. It is low here, because a step that lowers H may move the tip slightly, and near the target these strategies
# trade one for the other.
#
# Medians hide difficult cases. A performance profile (Dolan and Moré) shows them: for every strategy it plots the share
# of cases solved within a factor of the best time for that case. The left end shows which strategy is often the
# fastest, the right end which one solves most cases.

# %%
on_arm.plot_profile()

# %% [markdown]
# The profile of iterations differs, because one step of a strategy may take as long as ten of another.

# %%
on_arm.plot_profile(measure="iterations")

# %% [markdown]
# The task error by iteration: median and interquartile range. The plateau is the phase in which the tip stays close to
# the target while H decreases.

# %%
on_arm.plot_convergence(contenders=["hybrid", "hybrid+second_order", "transpose", "transpose_bb"])

# %% [markdown]
# The criterion by iteration in one case (left), and the regret of each strategy on all cases (right). The points at the
# right edge are cases in which a strategy ended in a worse minimum.

# %%
on_arm.plot_criteria()

# %% [markdown]
# The configurations of the arm in one case, from light to dark. Strategies that end in the same minimum take different
# paths to it.

# %%
on_arm.plot_postures(contenders=["hybrid", "hybrid+second_order", "transpose", "mink"])

# %% [markdown]
# ## A Panda
#
# The task is a pose in space with joint limits and without a criterion. Each strategy has one attempt from one start,
# without restarts. A strategy may be a name, an object with options, or another library, such as `"peer:mink"`. An
# unknown strategy, or one that is not installed, does not stop the study; its rows give the reason.

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
# The reasons for failures. All rows, one for each strategy and case, are available as a pandas frame. `to_csv`,
# `to_markdown`, `to_html` and `save` write them to files.

# %%
frame = on_panda.frame()
frame[~frame["success"]].groupby(["contender", "status"]).size()

# %% [markdown]
# ## With restarts
#
# In practice, a failed attempt is followed by a restart. Here are the same problems with up to 50 restarts within the
# limits:

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
# Without restarts, the fastest strategies and those that solve most cases are different ones. With restarts nearly all
# cases are solved. The time then depends on how soon an attempt succeeds or is abandoned.

# %%
restarted.plot_profile()
