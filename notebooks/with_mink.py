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
# mink solves differential inverse kinematics on MuJoCo models, with tasks and limits in one quadratic program for each
# step. Both directions work: a criterion of jtik as a task of mink, tasks and limits of mink in a solver of jtik, and
# the step of mink as a strategy, on the same problem.

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
# `to_mujoco` creates a MuJoCo model of any robot of jtik, with a body for every frame and a joint for every joint, of
# the same names. It can include obstacles. `Robot.from_mujoco(model)` reads an existing model.

# %%
ball = jtik.Sphere(center=(0.34, 0.21, 0.47), radius=0.08)  # [m]
model = to_mujoco(panda, obstacles=[ball])
mink.Configuration(model, start).get_transform_frame_to_world("panda_hand_tcp", "body").as_matrix() - panda.pose(start)

# %% [markdown]
# ## A criterion of jtik in mink
#
# The pose of the tool is a constraint, and H is minimised in its null space. `mink.solve_ik` returns a displacement if
# `dt` is 1. Pass its arguments by keyword.

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
# jtik finds the same posture on the same problem, and confirms that it is a minimum:

# %%
tool = jtik.FrameTask("panda_hand_tcp", kind="pose")
ik = jtik.InverseKinematics(panda, tool, criteria=JointCentering())
solution = ik.solve(pose, q0=start, trace=True)
print(solution)
print(f"second order: {solution.second_order}; mink ends {np.abs(configuration.q - solution.q).max():.1e} rad from it")

# %% [markdown]
# ## mink as a strategy
#
# `strategy="mink"` uses the step of mink with the same task, criterion and limits, and with the statuses and traces of
# jtik. A step runs in Python and in mink, so it takes longer.

# %%
mink_ik = jtik.InverseKinematics(panda, tool, criteria=JointCentering(), strategy="mink")
mink_solution = mink_ik.solve(pose, q0=start, trace=True)
mink_solution

# %% [markdown]
# ## A task of mink in jtik
#
# `Mink(tasks=[...])` adds tasks of mink with lower priority than those of jtik. A solve does not wait for their
# convergence, but they act in every step, which suits a path. The tool moves 0.3 m along y and back, and the task of
# mink keeps the elbow close to one position.

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
    print(f"{name}: {motion}; elbow {away.mean():.3f} m from its target on average")

# %% [markdown]
# ## A limit of mink in jtik
#
# A limit of mink has the form G dq ≤ h. `limit_rows` gives these rows for a robot of jtik, and a strategy adds them to
# its quadratic program. The strategy below moves to the target by damped least squares, within the joint limits and the
# rows. jtik provides everything else, such as stopping and the status.


# %%
class LimitedLeastSquares(jtik.Strategy):
    """min 1/2 |J dq + r|^2 + 1/2 mu |dq|^2, subject to a limit of mink."""

    def __init__(self, limit=None, mu=0.05):
        self._limit, self._mu = limit, mu

    def uses_qp(self, has_criterion):
        return True

    def update(self, model, state):
        J, r = model.J, model.here.residual
        low, high = model.box
        rows = [] if self._limit is None else [self._limit.rows(model)]
        P = J.T @ J + self._mu * np.eye(model.robot.n)
        dq = model.solve(jtik.qp.QuadraticProgram(P=P, q=J.T @ r, lower=low, upper=high, rows=rows)).x
        return jtik.strategy.Update(dq)


# %% [markdown]
# The hand must move from one side of the ball to the other. The limit of mink bounds the approach of every pair of
# geoms: with a gain of 0.5, a step may use half of the distance to the minimum distance. The rows are linear in dq,
# which is accurate for short steps only. The damping mu keeps the steps short.

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
    """Smallest distance of these geoms from the ball [m], negative for a collision."""
    data.qpos[:] = q
    mujoco.mj_forward(model, data)
    ball_id = model.geom("obstacle0").id
    return min(mujoco.mj_geomDistance(model, data, model.geom(name).id, ball_id, 2.0, None) for name in moving)


first, last = (panda.keyframes["home"] + [side, 0.45, 0, 0.2, 0, 0, 0] for side in (0.0, 1.1))
goal = panda.pose(last)
clearances = {}
for name, strategy in {
    "without the limit": LimitedLeastSquares(),
    "with mink's limit": LimitedLeastSquares(rows),
}.items():
    solver = jtik.InverseKinematics(panda, tool, strategy=strategy)
    found = solver.solve(goal, q0=first, max_iterations=300, trace=True)
    clearances[name] = np.array([clearance(q) for q in found.trace.q])
    print(f"{name:18} {found.status.value}; {found.iterations} iterations, minimum {clearances[name].min():.3f} m")
assert clearances["without the limit"].min() < 0 < clearances["with mink's limit"].min()

# %% [markdown]
# Left: the same criterion in both libraries leads to the same minimum. Middle: the same tool path without and with a
# task of mink for the elbow. Right: the same target without and with a limit of mink.

# %%
figure, (left, middle, right) = plt.subplots(1, 3, figsize=(14, 4.2), layout="constrained")
left.plot(H_mink, "o-", color="#d55e00", markersize=5, label="mink, criterion of jtik as a task")
left.plot([*mink_solution.trace.H, mink_solution.cost], "s--", color="#009e73", label='jtik, strategy="mink"')
left.plot([*solution.trace.H, solution.cost], "^-", color="#0072b2", markersize=5, label='jtik, strategy="hybrid"')
left.set(xlabel="iteration", ylabel="criterion H [rad²]")
time = motion.times
for (name, values), color, dashes in zip(elbows.items(), ("#d55e00", "#0072b2"), ("--", "-"), strict=True):
    middle.plot(time, np.linalg.norm(values - [0.0, -0.2, 0.6], axis=1), dashes, color=color, label=name)
middle.set(xlabel="time [s]", ylabel="elbow distance from its target [m]", ylim=(0, None))
for (name, values), color, dashes in zip(clearances.items(), ("#d55e00", "#0072b2"), ("--", "-"), strict=True):
    right.plot(values, dashes, color=color, label=name)
right.set_ylim(-0.07, None)
right.axhspan(-0.07, 0.0, color="gray", alpha=0.25, linewidth=0, label="inside the ball")
right.axhline(0.02, color="gray", linestyle=":", label="minimum distance of mink")
right.set(xlabel="iteration", ylabel="clearance of hand and forearm [m]")
for axes in (left, middle, right):
    axes.legend(frameon=False)
    axes.grid(alpha=0.3)
