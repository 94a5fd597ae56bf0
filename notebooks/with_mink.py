# ---
# jupyter:
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # Use it with mink
#
# mink solves differential inverse kinematics on MuJoCo models, with tasks and limits in one quadratic program a step.
# The two fit together both ways: a criterion of jtik's as a task of mink's, tasks and limits of mink's in a solver of
# jtik's, and mink itself as a strategy, on the very same problem.

# %%
import matplotlib.pyplot as plt
import mink
import mujoco
import numpy as np

import jtik
from jtik.interop.mink import criterion_task, limit_rows, to_mujoco
from jtik_formulations import JointCentering, Mink

panda = jtik.Robot.builtin("panda")
start = panda.keyframes["home"] + [0.5, 0.1, -0.3, 0.3, 0.3, 0.1, 0.0]  # [rad]

# %% [markdown]
# ## One robot, two libraries
#
# `to_mujoco` makes a MuJoCo model of any robot of jtik's: every frame a body of its name, every joint a joint of its
# name. The other way round, `Robot.from_mujoco(model)` reads a model you have. Obstacles may come along.

# %%
ball = jtik.Sphere(center=(0.34, 0.21, 0.47), radius=0.08)  # [m]
model = to_mujoco(panda, obstacles=[ball])
mink.Configuration(model, start).get_transform_frame_to_world("panda_hand_tcp", "body").as_matrix() - panda.pose(start)

# %% [markdown]
# ## A criterion of jtik's in mink
#
# The tool keeps its pose, as a constraint, and H is lowered by what is left. `mink.solve_ik` returns a displacement
# when `dt` is 1. Pass its arguments by keyword.

# %%
pose = panda.pose(start)
hold = mink.FrameTask("panda_hand_tcp", "body", position_cost=1.0, orientation_cost=1.0)
hold.set_target(mink.SE3.from_matrix(pose))
centre = criterion_task(JointCentering(), panda, model, gain=0.5)

configuration = mink.Configuration(model, start)
limits = [mink.ConfigurationLimit(model)]
H_mink = [centre.value(configuration)]
for _ in range(25):
    dq = mink.solve_ik(
        configuration=configuration, tasks=[centre], constraints=[hold], limits=limits, dt=1.0, solver="daqp"
    )
    configuration.integrate_inplace(dq, 1.0)
    H_mink.append(centre.value(configuration))

# %% [markdown]
# jtik on the same problem ends in the same posture, and says that this is a minimum:

# %%
tool = jtik.FrameTask("panda_hand_tcp", kind="pose")
ik = jtik.InverseKinematics(panda, tool, criteria=JointCentering())
solution = ik.solve(pose, q0=start, trace=True)
print(solution)
print(f"second order: {solution.second_order}; mink ends {np.abs(configuration.q - solution.q).max():.1e} rad from it")

# %% [markdown]
# ## mink as a strategy
#
# `strategy="mink"` takes mink's own step on the same task, criterion and limits, with jtik's statuses and traces round
# it. A step goes through Python and mink, and takes accordingly longer.

# %%
theirs = jtik.InverseKinematics(panda, tool, criteria=JointCentering(), strategy="mink")
theirs_solution = theirs.solve(pose, q0=start, trace=True)
theirs_solution

# %% [markdown]
# ## A task of mink's in jtik
#
# Any task of mink's can stand below those of jtik in `Mink(tasks=[...])`. A solve does not wait for it, it acts in
# every step that is taken: that fits a path. The tool moves 0.3 m along y and back, and mink's task wants the elbow in
# one place meanwhile.

# %%
there = np.linspace(0.0, -0.3, 60)
path = []
for y in [*there, *there[::-1]]:
    at = pose.copy()
    at[1, 3] += y
    path.append(at)

elbow = mink.FrameTask("panda_link4", "body", position_cost=1.0, orientation_cost=0.0)
elbow.set_target(mink.SE3.from_translation(np.array([0.0, -0.2, 0.6])))  # [m]
elbows = {}
for name, strategy in {"mink": Mink(), "mink with a task for the elbow": Mink(tasks=[elbow])}.items():
    motion = jtik.InverseKinematics(panda, tool, strategy=strategy).track(path, q0=start, dt=0.05)
    elbows[name] = np.array([panda.position(q, "panda_link4") for q in motion.q])
    away = np.linalg.norm(elbows[name] - [0.0, -0.2, 0.6], axis=1)
    print(f"{name}: {motion}; elbow {away.mean():.3f} m from its place on average")

# %% [markdown]
# ## A limit of mink's in jtik
#
# A limit of mink's is G dq ≤ h. `limit_rows` gives these rows for a robot of jtik's, and a strategy puts them into its
# program. Here is such a strategy in full: it goes to the target by damped least squares, within the joint limits and
# the rows. jtik does the rest, such as stopping and saying why.


# %%
class Kept(jtik.Strategy):
    """min 1/2 |J dq + r|^2 + 1/2 mu |dq|^2 under a limit of mink's."""

    def __init__(self, limit=None, mu=0.05):
        self._limit, self._mu = limit, mu

    def uses_qp(self, has_criterion):
        return True

    def update(self, model, state):
        J, r = model.full_J, model.here.residual
        low, high = model.box
        rows = [] if self._limit is None else [self._limit.rows(model)]
        P = J.T @ J + self._mu * np.eye(model.robot.n)
        dq = model.solve(jtik.qp.QuadraticProgram(P=P, q=J.T @ r, lower=low, upper=high, rows=rows)).x
        return jtik.strategy.Update(
            point=model.moved(-dq), accepted=1, state={}, term=-dq, wanted=-dq, null_term=0 * dq
        )


# %% [markdown]
# The hand has to get from one side of the ball to the other. What mink bounds is the approach of every pair of geoms:
# with a gain of 0.5 a step may take half of the way to the least distance. The rows are linear in dq, which holds for
# short steps only: mu keeps them short.

# %%
geoms = [name for name in (model.geom(i).name for i in range(model.ngeom)) if name.startswith("panda_")]
moving = [name for name in geoms if name.split()[0] in ("panda_link5", "panda_link6", "panda_link7", "panda_hand")]
avoid = mink.CollisionAvoidanceLimit(
    model,
    [(moving, ["obstacle0"])],
    gain=0.5,
    minimum_distance_from_collisions=0.02,
    collision_detection_distance=0.3,
)
rows = limit_rows(avoid, panda, model)

data = mujoco.MjData(model)


def clearance(q):
    """Distance of the ball from the nearest of these geoms [m], negative inside."""
    data.qpos[:] = q
    mujoco.mj_forward(model, data)
    ball_id = model.geom("obstacle0").id
    return min(mujoco.mj_geomDistance(model, data, model.geom(name).id, ball_id, 2.0, None) for name in moving)


from_here, to_there = (panda.keyframes["home"] + [side, 0.45, 0, 0.2, 0, 0, 0] for side in (0.0, 1.1))
goal = panda.pose(to_there)
ways = {}
for name, strategy in {"without the limit": Kept(), "with mink's limit": Kept(rows)}.items():
    solver = jtik.InverseKinematics(panda, tool, strategy=strategy)
    found = solver.solve(goal, q0=from_here, max_iterations=300, trace=True)
    ways[name] = np.array([clearance(q) for q in found.trace.q])
    print(f"{name:18} {found.status.value}; {found.iterations} iterations, least {ways[name].min():.3f} m")
assert ways["without the limit"].min() < 0 < ways["with mink's limit"].min()

# %% [markdown]
# What the three have done. Left: one criterion in two libraries ends in one minimum. Middle: the same tool path, with
# the elbow left to itself and drawn to its place by a task of mink's. Right: the same target, with and without a limit
# of mink's.

# %%
figure, (left, middle, right) = plt.subplots(1, 3, figsize=(14, 4.2), layout="constrained")
left.plot(H_mink, "o-", color="#d55e00", markersize=5, label="mink, with jtik's criterion as a task")
left.plot([*theirs_solution.trace.H, theirs_solution.cost], "s--", color="#009e73", label='jtik, strategy="mink"')
left.plot([*solution.trace.H, solution.cost], "^-", color="#0072b2", markersize=5, label='jtik, strategy="hybrid"')
left.set(xlabel="iteration", ylabel="criterion H [rad²]")
time = motion.times
for (name, way), color, dashes in zip(elbows.items(), ("#d55e00", "#0072b2"), ("--", "-"), strict=True):
    middle.plot(time, np.linalg.norm(way - [0.0, -0.2, 0.6], axis=1), dashes, color=color, label=name)
middle.set(xlabel="time [s]", ylabel="elbow from its place [m]", ylim=(0, None))
for (name, way), color, dashes in zip(ways.items(), ("#d55e00", "#0072b2"), ("--", "-"), strict=True):
    right.plot(way, dashes, color=color, label=name)
right.set_ylim(-0.07, None)
right.axhspan(-0.07, 0.0, color="gray", alpha=0.25, linewidth=0, label="inside the ball")
right.axhline(0.02, color="gray", linestyle=":", label="least distance asked of mink")
right.set(xlabel="iteration", ylabel="hand and forearm from the ball [m]")
for axes in (left, middle, right):
    axes.legend(frameon=False)
    axes.grid(alpha=0.3)
