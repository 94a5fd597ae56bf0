# ---
# jupyter:
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # Any function as a criterion
#
# What can be computed from q can be minimised: a query of a physics engine, a trained network, a table. Two examples,
# on a Panda that holds its tool at a pose: the distance to a tilted box, by MuJoCo, and a small network that has
# learned which postures are comfortable.

# %%
import matplotlib.pyplot as plt
import mujoco
import numpy as np
from sklearn.neural_network import MLPRegressor

import jtik
from jtik.interop.mink import to_mujoco
from jtik.testing import check_criterion

panda = jtik.Robot.builtin("panda")
tool = jtik.FrameTask("panda_hand_tcp", kind="pose")
start = panda.keyframes["home"] + [0.5, 0.1, -0.3, 0.3, 0.3, 0.1, 0.0]  # [rad]
pose = panda.pose(start)

# %% [markdown]
# ## Distances by MuJoCo
#
# `mj_geomDistance` returns the signed distance of two geoms and the two points where they are closest. A box stands
# beside the elbow.

# %%
angle = 0.4
box_pose = np.eye(4)
box_pose[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
box_pose[:3, 3] = [-0.2, -0.3, 0.65]  # [m]
model = to_mujoco(panda, obstacles=[jtik.Box(pose=box_pose, half=[0.08, 0.08, 0.15])])
data = mujoco.MjData(model)
links = [i for i in range(model.ngeom) if model.geom_type[i] == mujoco.mjtGeom.mjGEOM_CAPSULE]
(box,) = [i for i in range(model.ngeom) if model.geom_type[i] == mujoco.mjtGeom.mjGEOM_BOX]


def closest(q, reach):
    """Distance of each link to the box [m], and its gradient: the normal times the Jacobian of the closest point."""
    data.qpos[:] = q
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    points, J = np.zeros(6), np.zeros((3, model.nv))
    for geom in links:
        distance = mujoco.mj_geomDistance(model, data, geom, box, reach, points)
        if distance < reach and abs(distance) > 1e-9:
            mujoco.mj_jac(model, data, J, None, points[:3], model.geom_bodyid[geom])
            yield distance, (points[:3] - points[3:]) / distance @ J


# %% [markdown]
# The criterion is the sum of the cubes by which the links are closer than `reach`, a live parameter. H and its gradient
# are smooth where a link enters the range. When the solver is built, the gradient is compared with the function.


# %%
def box_gradient(q, *, reach):
    return sum((-3 * (reach - d) ** 2 / reach**3 * gradient for d, gradient in closest(q, reach)), np.zeros(model.nv))


@jtik.criterion(numeric=True, gradient=box_gradient)
def box_distance(q, *, reach=0.15):
    return sum(((reach - d) / reach) ** 3 for d, _ in closest(q, reach))


check_criterion(box_distance, panda, samples=[start])
ik = jtik.InverseKinematics(panda, tool, criteria=box_distance)
away = ik.solve(pose, q0=start)
print(away)
print(f"calls: {away.evaluations}")


def smallest(q):
    return min((d for d, _ in closest(q, 1.0)), default=1.0)


print(f"smallest distance: {smallest(start):.3f} m before, {smallest(away.q):.3f} m after")
assert smallest(away.q) > smallest(start)

# %% [markdown]
# ## A network by scikit-learn
#
# In practice the data would come from people who rated postures, or from a slow simulation. Here the rating is a
# formula that the network does not know. `tanh` keeps it smooth. Without a gradient jtik takes central differences:
# 15 calls a step for seven joints.

# %%
generator = np.random.default_rng(0)
postures = start + generator.uniform(-0.8, 0.8, (3000, 7))
rating = np.array([np.sum((q - start - 0.3) ** 2) + np.sin(3 * q[2]) for q in postures])
network = MLPRegressor(
    random_state=0, hidden_layer_sizes=(24, 24), activation="tanh", solver="lbfgs", alpha=0.05, tol=1e-3, max_iter=3000
)
network.fit(postures, rating)


@jtik.criterion(numeric=True)
def comfort(q):
    return float(network.predict(q[None])[0])


comfortable = jtik.InverseKinematics(panda, tool, criteria=comfort).solve(pose, q0=start)
print(comfortable)
assert comfort(comfortable.q, panda) < comfort(start, panda)

# %% [markdown]
# ## Both
#
# Numeric criteria add and scale as all others, with any strategy. Only `compiled=True` is refused, because generated C
# cannot call Python.

# %%
together = jtik.InverseKinematics(panda, tool, criteria=box_distance + 0.05 * comfort, strategy="newton+qp")
both = together.solve(pose, q0=start)
print(both)

# %% [markdown]
# The self-motion of the arm at this pose, and where the three criteria put it: found by following the null space from
# `start` in both directions.


# %%
def self_motion(q, sign, steps=120, length=0.02):
    """Configurations with the tool at `pose`, along the null space of the Jacobian."""
    hold = jtik.InverseKinematics(panda, tool)
    direction, found = None, []
    for _ in range(steps):
        null = np.linalg.svd(np.asarray(panda.jacobian(q, "panda_hand_tcp")))[2][-1]
        direction = sign * null if direction is None else null * np.sign(null @ direction)
        q = hold.solve(pose, q0=q + length * direction).q
        found.append(q)
    return found


way = [*self_motion(start, -1.0)[::-1], start, *self_motion(start, 1.0)]
distances = [smallest(q) for q in way]
ratings = [comfort(q, panda) for q in way]
along = 0.02 * (np.arange(len(way)) - 120)

figure, (upper, lower) = plt.subplots(2, 1, figsize=(7, 5), sharex=True, layout="constrained")
upper.plot(along, distances, color="#1f4e79")
lower.plot(along, ratings, color="#1f4e79")
for solution, label, colour in (
    (away, "box", "#b5402f"),
    (comfortable, "comfort", "#2e7d4f"),
    (both, "both", "#7a5195"),
):
    at = along[int(np.argmin([np.linalg.norm(q - solution.q) for q in way]))]
    for axes in (upper, lower):
        axes.axvline(at, color=colour, label=label)
upper.set_ylabel("distance to the box [m]")
lower.set_ylabel("rating by the network")
lower.set_xlabel("way along the self-motion [rad]")
upper.legend(frameon=False)
