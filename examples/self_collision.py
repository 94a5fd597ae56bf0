"""The pairs of a robot's bodies that can touch, and two ways to keep them apart: a cost, and rows that guarantee it."""

import jtik
from jtik_formulations import SelfCollision

panda = jtik.Robot.builtin("panda")
pairs = panda.collision_pairs()
print(f"{len(pairs)} pairs of {len(pairs.bodies)} bodies can touch, {len(pairs.left_out)} are left out; the first:")
print("\n".join(str(pairs).splitlines()[:4]))

apart = SelfCollision()
touching = SelfCollision(influence=0.001)  # its H is zero unless bodies are within 1 mm
solvers = {
    "neither": {},
    "cost": {"criteria": 10 * apart},
    "rows": {"clearances": jtik.Clearance(apart, safe=0.005)},
}
for name, how in solvers.items():
    ik = jtik.InverseKinematics(panda, jtik.FrameTask("tip", kind="position"), strategy="hybrid+qp", **how)
    solution = ik.solve([-0.3, 0.15, 0.2], q0=panda.home, trace=True)  # behind the base
    through = sum(touching(q, panda) > 0 for q in solution.trace.q)
    print(
        f"{name}: off by {1e3 * solution.position_error:.3f} mm, in collision at {through} configurations on the way"
        f" and {'' if touching(solution.q, panda) else 'not '}at the end"
    )
assert not through  # with rows
