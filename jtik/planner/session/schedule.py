"""When the next period of the loop is due: late periods are left out, not made up for."""

from __future__ import annotations

EARLY = 0.12
"""Share of a period by which an edit may begin the next period before it is due."""

PULL = 0.04
"""Largest share of a period by which one edit shifts the periods."""


class Schedule:
    """Periods of equal length, which begin when edits come that are in time with them.

    An edit that comes shortly before a period is due begins it at once. The periods are shifted, by half a period at
    most, so that the edits of a motion come then: those of a pointer have a rhythm of their own, and the arm answers
    them without a wait. There are no more periods than without edits.

    Args:
        period: length of a period [s].
        now: when the first one is due [s].

    Attributes:
        late: periods that were left out so far.
    """

    def __init__(self, period: float, now: float) -> None:
        self._period, self._due, self.late = period, now, 0
        self._shift = 0.0  # of all edits together, as a share of a period: from -0.5 to 0.5

    def wait(self, now: float) -> float:
        """How long to wait until the next period is due [s]; 0 for one that is due."""
        return max(0.0, self._due - now)

    def asked(self, now: float) -> float:
        """An edit has come: how long to wait until the next period begins [s]; 0 where the edit begins it."""
        wait = self.wait(now)
        if wait <= EARLY * self._period:
            wait = 0.0
        offset = (now - self._due) / self._period + EARLY / 2  # 0 in the middle of the time in which one begins
        wanted = self._shift + offset
        pull = max(-PULL, min(PULL, wanted - round(wanted) - self._shift))
        self._shift += pull
        self._due += pull * self._period
        return wait

    def done(self, now: float) -> None:
        """Note that the period that was due has ended."""
        self._due += self._period
        if now > self._due:
            missed = int((now - self._due) / self._period)
            self._due += missed * self._period
            self.late += missed
