"""Where the attempts of a search ended that did not reach the target."""

from __future__ import annotations

from jtik.types import Array

TIE = 1e-3
"""Relative difference of the errors of a level of priority below which the next level decides."""


class Ends:
    """Where attempts that did not reach the target ended: the first of them, and the one with the smallest error.

    An error is V; with several levels of priority the errors of the levels, the highest first.
    """

    def __init__(self) -> None:
        self.first: Array | None = None
        self.best: tuple[tuple[float, ...], int, Array] | None = None

    def add(self, number: int, errors: tuple[float, ...], q: Array) -> None:
        """Attempt ``number`` ended at ``q`` with these errors."""
        if number == 0:
            self.first = q.copy()
        if self.best is None or smaller(errors, self.best[0]):
            self.best = errors, number, q.copy()

    def to_continue(self) -> list[Array]:
        """The ends that are worth going on from: that with the smallest error, and that of the caller's own start."""
        assert self.best is not None
        return [self.best[2]] if self.best[1] == 0 or self.first is None else [self.best[2], self.first]


def smaller(errors: tuple[float, ...], than: tuple[float, ...]) -> bool:
    """Whether errors by level are smaller than others: the first level in which they differ decides."""
    for one, other in zip(errors[:-1], than[:-1], strict=True):
        if abs(one - other) > TIE * max(one, other):
            return one < other
    return errors[-1] < than[-1]
