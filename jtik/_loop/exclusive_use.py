"""One call at a time: the guard around everything that uses the memory of a solver."""

from __future__ import annotations

from jtik.errors import JtikError


class ExclusiveUse:
    """A guard that refuses a second call, of another thread or from within the first, and does not wait.

    A call reads and sets `busy` itself, in a fifth of the time that a lock takes::

        if guard.busy:
            raise in_use()
        try:
            guard.busy = True  # nothing that is called stands between the test and this
            ...
        finally:
            guard.busy = False

    The interpreter changes threads and delivers signals where something is called or a loop goes round, which is not
    the case from the test to the assignment. So neither a thread nor Ctrl-C can come in between; a test reads it from
    the instructions of every such method. An interpreter without a global lock takes one when it imports CasADi.
    A solve in C (`jtik._loop.native.solve`) reads and sets it there.

    Attributes:
        busy: whether a call is within.
    """

    __slots__ = ("busy",)

    def __init__(self) -> None:
        self.busy = False


def in_use() -> JtikError:
    """The error of a second call."""
    return JtikError(
        "this InverseKinematics is in use, by another thread or by the call from which this one was made: "
        "one solver a thread, and another one within a callback; copy.copy(ik) is cheap"
    )
