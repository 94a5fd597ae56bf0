"""Turn the elbow of a Panda from the keyboard, while its hand stays where it is.

Keys: a and d turn it, q ends. Without a terminal some keys are played.
"""

import sys
from contextlib import contextmanager

import numpy as np

import jtik


@contextmanager
def keyboard():
    """An iterator of the keys that are pressed, without the Enter key."""
    if not sys.stdin.isatty():
        yield iter("dddddddddaaaq")
    elif sys.platform == "win32":
        import msvcrt

        yield iter(msvcrt.getwch, None)
    else:
        import termios
        import tty

        before = termios.tcgetattr(sys.stdin)
        try:
            tty.setcbreak(sys.stdin)
            yield iter(lambda: sys.stdin.read(1), "")
        finally:
            termios.tcsetattr(sys.stdin, termios.TCSADRAIN, before)


panda = jtik.Robot.builtin("panda")
ik = jtik.InverseKinematics(panda, jtik.FrameTask("tip", kind="pose"))
rates = {"a": -2.0, "d": 2.0}  # [rad/s], of all joints together
q, hand, drift = panda.home, panda.position(panda.home), 0.0
print("a, d: turn the elbow; q: end")
with keyboard() as keys:
    for key in keys:
        if key == "q":
            break
        if key in rates:
            jog = ik.jog(q, rates[key], direction="panda_joint1", dt=0.05)
            q = jog.q
            drift = np.linalg.norm(panda.position(q) - hand)
            print(
                f"{key}  elbow at {panda.position(q, 'panda_link4').round(3)}, hand off by {drift:.0e} m; {jog.reason}"
            )
assert drift < 1e-6
