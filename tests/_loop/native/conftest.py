"""What a call runs in Python, for the tests of calls that are to stay in C."""

from __future__ import annotations

import sys


def python_calls(call):
    """Names of the Python functions that a call runs besides the method of `InverseKinematics`."""
    names = []

    def note(frame, event, argument):
        if event == "call":
            names.append(frame.f_code.co_qualname)

    before = sys.getprofile()
    sys.setprofile(note)
    try:
        call()
    finally:
        sys.setprofile(before)
    assert names.pop(0) == call.__qualname__
    assert names.pop(0) in ("InverseKinematics.solve", "InverseKinematics.step")
    return names
