"""One displacement along the self-motion."""

from __future__ import annotations

from typing import NamedTuple

from jtik.types import Array


class Jog(NamedTuple):
    """One displacement along the self-motion, for an operator's control.

    Attributes:
        q: configuration after it, (nq,) [rad] and [m].
        rate: signed speed along the self-motion that was reached [rad/s]; 0 where it has ended.
        position_error: change of the position rows of the task in this call [m].
        orientation_error: change of its orientation rows [rad].
        ended: whether the self-motion goes no further in this direction; with the opposite sign it comes back.
        reason: what was done, and what slowed or ended it, in words.
    """

    q: Array
    rate: float
    position_error: float
    orientation_error: float
    ended: bool
    reason: str
