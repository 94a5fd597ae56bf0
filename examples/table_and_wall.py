"""A Panda over a table, beside a wall and a box: hard rows keep its bodies 5 mm off everything and off each other."""

import numpy as np

import jtik
from jtik_formulations import ObstacleBarrier, SelfCollision

panda = jtik.Robot.builtin("panda")
scene = jtik.Scene(
    {
        "table": jtik.Box.at([0.65, 0.0, 0.05], [0.4, 0.7, 0.02]),
        "wall": jtik.HalfSpace([0.0, 0.6, 0.0], [0.0, -1.0, 0.0]),
        "box": jtik.Box.at([0.5, -0.15, 0.19], [0.08, 0.1, 0.12]),
    }
)
bodies = ObstacleBarrier(scene, bodies="shapes", capacity={"box": 3, "half_space": 1})  # room for another box
ik = jtik.InverseKinematics(
    panda,
    jtik.FrameTask("tip", kind="pose"),
    strategy="hybrid+qp",
    clearances=[
        jtik.Clearance(bodies, safe=0.005, margin=0.004, name="scene"),
        jtik.Clearance(SelfCollision(), safe=0.005, margin=0.004, name="body"),
    ],
)

tool_down = panda.pose(panda.home)
q = panda.home
for x, y, z in [(0.5, 0.3, 0.25), (0.6, 0.1, 0.2), (0.5, -0.15, 0.4), (0.5, -0.15, 0.3)]:  # the last is in the box
    goal = tool_down.copy()
    goal[:3, 3] = x, y, z
    solution = ik.solve(goal, q0=q)
    q = solution.q
    where = "reached" if solution.status.on_target else f"off by {1e3 * solution.position_error:.0f} mm"
    print(f"({x}, {y}, {z}): {where}; at their smallest distance: {', '.join(solution.active_clearances) or 'none'}")

# the box goes, and another one comes, without a rebuild
print("slots:", bodies.slots(panda).names)
ik.parameters["scene.gains"] = np.array([1.0, 0.0, 0.0, 1.0])
solution = ik.solve(goal, q0=q)
print("without the box:", solution.status.name)
assert solution.status.on_target
