"""The queue between the threads that submit edits and the loop that applies them."""

from __future__ import annotations

import threading

from jtik.planner.edits.messages import (
    ChangeObstacle,
    Edit,
    HoldTarget,
    Jog,
    MoveTarget,
    SetGain,
    SetJointWeights,
    SetObstacleGain,
    SetPreferred,
    SetTargetSpeed,
)
from jtik.planner.edits.of_attempts import Scrub

LARGEST = 1000
"""Largest number of edits that wait."""


class Inbox:
    """A bounded queue of edits. Of edits that replace one another only the latest is kept, in its own place.

    Args:
        largest: largest number of edits that wait; one of the target is accepted beyond it.

    Attributes:
        filled: set while edits wait.
    """

    def __init__(self, largest: int = LARGEST) -> None:
        self._largest, self._count, self._refused = largest, 0, 0
        self.filled = threading.Event()
        self._waiting: dict[object, Edit] = {}
        self._lock = threading.Lock()

    def put(self, edit: Edit) -> bool:
        """Add an edit; False where the queue is full."""
        key = _replaced(edit)
        with self._lock:
            if key is not None:
                self._waiting.pop(key, None)
            if len(self._waiting) >= self._largest and not isinstance(edit, (MoveTarget, HoldTarget, Jog)):
                self._refused += 1
                return False
            self._count += 1
            self._waiting[self._count if key is None else key] = edit
            self.filled.set()
            return True

    def take(self) -> tuple[list[Edit], int]:
        """All edits that wait, in their order, and how many were refused since the last call."""
        with self._lock:
            if not self._waiting and not self._refused:
                return [], 0
            edits, refused = list(self._waiting.values()), self._refused
            self._waiting, self._refused = {}, 0
            self.filled.clear()
        return edits, refused


def _replaced(edit: Edit) -> object:
    """What an edit replaces; None where every one counts."""
    if isinstance(edit, (MoveTarget, HoldTarget)):
        return "target"
    if isinstance(edit, (Jog, SetTargetSpeed, Scrub)):
        return edit.kind
    if isinstance(edit, (ChangeObstacle, SetObstacleGain)):
        return edit.kind, edit.name
    if isinstance(edit, SetPreferred):
        return edit.kind, edit.joint
    if isinstance(edit, SetJointWeights):
        return edit.kind, *edit.weights
    return (edit.kind, edit.parameter) if isinstance(edit, SetGain) else None
