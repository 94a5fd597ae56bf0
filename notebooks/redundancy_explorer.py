# ---
# jupyter:
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # Redundancy explorer
#
# A seven-joint arm that holds its tool at a fixed pose can still move: the configurations that reach the pose form
# curves, and the arm can be jogged along them. This notebook finds all curves, plots a criterion along them, and checks
# that the solver finds its optima.

# %%
import casadi
import matplotlib.pyplot as plt
import numpy as np

import jtik

panda = jtik.Robot.builtin("panda")
tool = jtik.FrameTask("panda_hand_tcp", kind="pose")
middle = (panda.lower + panda.upper) / 2  # of the joint ranges [rad]
pose = panda.pose(panda.keyframes["home"] + [0.3, 0.2, -0.4, 0.3, 0.4, -0.2, 0.3])  # an arbitrary pose
pose.round(3)

# %% [markdown]
# ## Jog in the null space
#
# A velocity t with J t = 0 moves the joints but not the tool. J is 6 × 7, so at a regular pose t is unique up to scale:
# the last right singular vector. A step along it has a second-order error, which a solve without a criterion corrects.
# Joint limits are ignored at first. Without them, every curve is closed.

# %%
on_pose = jtik.InverseKinematics(panda, tool, strategy="newton", limits=False)


def distance(a, b):
    """Distance of configurations modulo 2 pi [rad]."""
    return np.linalg.norm((a - b + np.pi) % (2 * np.pi) - np.pi, axis=-1)


def jog(q, step=0.03):
    """The closed curve of self-motion through q, as configurations `step` [rad] apart, (k, 7)."""
    path, before = [q], None
    while len(path) < 5000:
        along = np.linalg.svd(panda.jacobian(q))[2][-1]
        along = along if before is None or along @ before > 0 else -along  # keep the direction
        solution = on_pose.solve(pose, q0=q + step * along, until="reached")
        assert solution.converged, solution
        q, before = solution.q, along
        if len(path) > 5 and distance(q, path[0]) < 0.7 * step:  # back at the start, up to full turns of some joints
            return np.array([*path, path[0] + 2 * np.pi * np.round((q - path[0]) / (2 * np.pi))])
        path.append(q)
    raise RuntimeError("the curve did not close")


# %% [markdown]
# ## All the curves
#
# Random starts find configurations at the pose. A configuration on none of the known curves starts a new one. Most
# curves are found by the first starts; the other starts check that none is missing.

# %%
rng = np.random.default_rng(0)
curves = []
for start in rng.uniform(-np.pi, np.pi, (300, 7)):
    solution = on_pose.solve(pose, q0=start, until="reached")
    if solution.converged and all(distance(curve, solution.q).min() > 0.03 for curve in curves):
        curves.append(jog(solution.q))

print(len(curves), "curves of self-motion; full turns of each joint along the curve:")
for number, curve in enumerate(curves, 1):
    turns = np.round((curve[-1] - curve[0]) / (2 * np.pi)).astype(int) + 0
    sigma = min(np.linalg.svd(panda.jacobian(q), compute_uv=False)[-1] for q in curve)
    length = np.linalg.norm(np.diff(curve, axis=0), axis=1).sum()
    print(f"  {number}: {length:5.1f} rad long, turns {turns}, smallest singular value {sigma:.3f}")

# %% [markdown]
# Along a complete curve one or two joints make a full turn, and all joints return to their start. There is no path from
# one curve to another that keeps the pose of the tool.
#
# ## A criterion
#
# The distance from the middle of each joint's range, in a form that is continuous over full turns. Its sign is a live
# parameter: with −1 the solver, which minimises, finds maxima.


# %%
@jtik.criterion
def off_centre(q, robot, *, sign=1.0):
    """H = sum of 1 - cos(q - middle) [1]; close to the middle it is half the squared distance [rad^2]."""
    return sign * casadi.sum1(1 - np.cos(q - middle))


def landscape(curve):
    """Arc length [rad] and H along a curve."""
    s = np.concatenate([[0], np.linalg.norm(np.diff(curve, axis=0), axis=1).cumsum()])
    return s, (1 - np.cos(curve - middle)).sum(axis=1)


# %% [markdown]
# ## All of its optima
#
# An optimum of the plotted H is a point where H changes between rising and falling. The solver uses no plot: it
# descends from its starts, here points along all curves, until the null-space residual is zero. `Solution.second_order`
# classifies the result by the eigenvalues of the Hessian of H + λᵀr along the self-motion: "minimum", or "saddle" if H
# can still decrease. With one dimension of self-motion such a saddle is a maximum.

# %%
free = jtik.InverseKinematics(panda, tool, criteria=off_centre, limits=False)


def optima(solver, starts, sign):
    """Distinct configurations where solves from these starts converge, for H or for -H."""
    solver.parameters["off_centre.sign"] = sign
    found = []
    for start in starts:
        solution = solver.solve(pose, q0=start)
        if solution.status is jtik.Status.CONVERGED and all(distance(q, solution.q) > 1e-3 for q in found):
            found.append(solution.q)
    solver.parameters["off_centre.sign"] = 1.0
    return [solver.solve(pose, q0=q, max_iterations=0) for q in found]  # evaluates H itself


along = np.concatenate([curve[::25] for curve in curves])
lowest, highest = optima(free, along, 1.0), optima(free, along, -1.0)


def place(q):
    """The curve of a configuration, and the index of its nearest point."""
    number = int(np.argmin([distance(curve, q).min() for curve in curves]))
    return number, int(distance(curves[number], q).argmin())


# %% [markdown]
# Comparison with the plotted curves: the solver finds every optimum, and no other point.

# %%
print("curve  minima (solver / curve)  maxima (solver / curve)")
for number, curve in enumerate(curves):
    rises = np.diff(landscape(curve)[1]) > 0
    valleys, peaks = np.sum(~rises & np.roll(rises, -1)), np.sum(rises & ~np.roll(rises, -1))
    low, high = (sum(place(each.q)[0] == number for each in found) for found in (lowest, highest))
    print(f"{number + 1:5}  {low:6} / {valleys:<20} {high:6} / {peaks}")
    assert (low, high) == (valleys, peaks)
assert {each.second_order for each in lowest} == {"minimum"}
assert {each.second_order for each in highest} == {"saddle"}
off = max(distance(curves[place(each.q)[0]], each.q).min() for each in lowest + highest)
print(f"{len(lowest)} minima, {len(highest)} maxima, at most {off:.3f} rad from the nearest point of their curve")
assert off < 0.02  # points are 0.03 rad apart

# %% [markdown]
# In practice a solver starts away from the curves, and its start determines the minimum. Some minima are found often,
# others rarely:

# %%
reached = np.zeros(len(lowest), dtype=int)
for start in rng.uniform(-np.pi, np.pi, (200, 7)):
    solution = free.solve(pose, q0=start)
    distances = [distance(each.q, solution.q) for each in lowest]
    if solution.converged:
        assert min(distances) < 1e-3  # always one of the known minima
        reached[np.argmin(distances)] += 1
for number, each in sorted(zip(reached, lowest, strict=True), key=lambda pair: -pair[0]):
    print(f"{number:4} of 200 random starts end on curve {place(each.q)[0] + 1} at H = {each.cost:.3f}")

# %% [markdown]
# ## With joint limits
#
# The limits cut arcs out of the curves; most curves lie outside the limits completely. If H decreases towards the end
# of an arc, the end is a minimum as well, with an active limit, which `active_limits` names.

# %%
limited = jtik.InverseKinematics(panda, tool, criteria=off_centre)
inside = optima(limited, [panda.random_configuration(rng) for _ in range(200)], 1.0)
for solution in sorted(inside, key=lambda each: each.cost):
    active = ", ".join(solution.active_limits) or "no limit"
    print(f"curve {place(solution.q)[0] + 1}: H = {solution.cost:.3f}, {solution.second_order}, at {active}")

# %% [markdown]
# ## The map
#
# Each panel shows H along one curve over its arc length, thick where all joints are within their limits. Markers are
# results of solves. The real arm can use parts of two of the eight curves. There are five minima there, three inside an
# arc and two at the end of one, and the best is much lower than the others. A descent finds a local minimum only: a
# minimum on another curve, or beyond a maximum or a limit, needs another start.

# %%
figure, panels = plt.subplots(2, 4, figsize=(13, 6), sharey=True, layout="constrained")
for number, (axes, curve) in enumerate(zip(panels.flat, curves, strict=True)):
    s, H = landscape(curve)
    centred = (curve - middle + np.pi) % (2 * np.pi) - np.pi
    usable = (np.abs(centred) <= (panda.upper - panda.lower) / 2).all(axis=1)
    axes.plot(s, H, color="#888888", linewidth=1)
    axes.plot(s, np.where(usable, H, np.nan), color="#0072b2", linewidth=4, alpha=0.6)
    for found, style in (
        (lowest, {"marker": "v", "color": "#009e73", "label": "minimum"}),
        (highest, {"marker": "^", "color": "#d55e00", "label": "maximum"}),
        (inside, {"marker": "o", "color": "black", "label": "minimum within the limits", "markerfacecolor": "none"}),
    ):
        points = [(s[at], each.cost) for each in found for where, at in [place(each.q)] if where == number]
        size = 11 if found is inside else 7
        axes.plot(*np.array(points or np.empty((0, 2))).T, linestyle="none", markersize=size, **style)
    axes.set_title(f"curve {number + 1}", fontsize=10, loc="left")
    axes.grid(alpha=0.3)
figure.supxlabel("arc length of the self-motion [rad]")
figure.supylabel("criterion H")
_ = figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside upper right", ncols=3, frameon=False)
