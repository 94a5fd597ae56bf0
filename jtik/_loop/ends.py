"""Where the attempts of a search ended that did not reach the target."""

from __future__ import annotations

from jtik.types import Array


class Ends:
    """Where attempts that did not reach the target ended: the first of them, and the one with the smallest error."""

    def __init__(self) -> None:
        self.first: Array | None = None
        self.best: tuple[float, int, Array] | None = None

    def add(self, number: int, V: float, q: Array) -> None:
        """Attempt ``number`` ended at ``q`` with the Lyapunov function V."""
        if number == 0:
            self.first = q.copy()
        if self.best is None or self.best[0] > V:
            self.best = V, number, q.copy()

    def to_continue(self) -> list[Array]:
        """The ends that are worth going on from: that with the smallest error, and that of the caller's own start."""
        assert self.best is not None
        return [self.best[2]] if self.best[1] == 0 or self.first is None else [self.best[2], self.first]
