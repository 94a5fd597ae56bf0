"""One thread at a time: the guard around everything that uses the memory of a solver."""

from __future__ import annotations

import threading
from types import TracebackType

from jtik.errors import JtikError


class ExclusiveUse:
    """A guard that refuses a second thread and does not wait for the first. The same thread may enter again.

    ``with guard:`` is for calls that take long; a short call uses ``acquire`` and ``release``, in half the time.

    Attributes:
        acquire: ``acquire(False)`` enters, and returns whether it could.
        release: leaves.
    """

    def __init__(self) -> None:
        lock = threading.RLock()
        self.acquire = lock.acquire
        self.release = lock.release

    def __enter__(self) -> None:
        if not self.acquire(False):
            raise in_use()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.release()


def in_use() -> JtikError:
    """The error of a second thread."""
    return JtikError(
        "this InverseKinematics is in use by another thread: make one for each thread, for instance by copy.deepcopy"
    )
