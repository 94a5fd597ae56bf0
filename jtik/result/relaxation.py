"""A constraint that was relaxed, and by how much."""

from __future__ import annotations

from typing import NamedTuple


class Relaxation(NamedTuple):
    """A constraint or a task that cannot be met at the configuration of a Solution.

    Attributes:
        name: what was relaxed, such as "task step" or "clearance: link4 to obstacle 1".
        amount: by how much.
        unit: unit of the amount, such as "m"; "share" for a fraction; empty where there is none.
    """

    name: str
    amount: float
    unit: str

    def __str__(self) -> str:
        if self.unit == "share":
            return f"{self.name} by {100 * self.amount:.0f} %"
        return f"{self.name} by {self.amount:.3g} {self.unit}".rstrip()
