"""jtik, mink and pink on the same problems, as a table; `jtik list peers` names more libraries.

A library that is not installed has a row that says so: python -m pip install pin-pink
"""

import jtik

comparison = jtik.compare(
    jtik.Robot.builtin("panda"),
    jtik.FrameTask("tip", kind="pose"),
    strategies=["hybrid", "damped", "peer:mink", "peer:pink"],
    problems={"reachable": 20},
    restarts=20,
)
print(comparison)
