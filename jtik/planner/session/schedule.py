"""When the next period of the loop is due: late periods are left out, not made up for."""

from __future__ import annotations


class Schedule:
    """Periods of equal length.

    Args:
        period: length of a period [s].
        now: when the first one is due [s].

    Attributes:
        late: periods that were left out so far.
    """

    def __init__(self, period: float, now: float) -> None:
        self._period, self._due, self.late = period, now, 0

    def wait(self, now: float) -> float:
        """How long to wait until the next period is due [s]; 0 for one that is due."""
        return max(0.0, self._due - now)

    def done(self, now: float) -> None:
        """Note that the period that was due has ended."""
        self._due += self._period
        if now > self._due:
            missed = int((now - self._due) / self._period)
            self._due += missed * self._period
            self.late += missed
