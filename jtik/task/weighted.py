"""The options that all tasks of jtik share: stiffness, priority, name, and the rows to keep."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from jtik.errors import ArgumentError
from jtik.task.base import Task
from jtik.types import Array

Axes = str | Sequence[str] | None
"""Names of the rows to keep, in order: "xy" or ("x", "rz"); None keeps all."""


class WeightedTask(Task):
    """Base of tasks with a stiffness Kp, a level of priority and a name.

    Args:
        stiffness: a positive scalar, one value for each row, or a symmetric positive definite matrix (m, m).
        priority: level for strategies with levels of priority; 0 is the highest.
        name: name of the task in a dict of targets.

    Raises:
        ArgumentError: when the stiffness is not finite or the priority is not a non-negative integer.
    """

    def __init__(self, *, stiffness: ArrayLike, priority: int, name: str) -> None:
        if not isinstance(priority, int) or priority < 0:
            raise ArgumentError("priority", priority, "a non-negative integer; 0 is the highest level")
        self.priority = priority
        self.name = name
        accepted = "a finite scalar, one value for each row, or a square matrix"
        try:
            self.stiffness = np.array(stiffness, dtype=np.float64)
        except (TypeError, ValueError):
            raise ArgumentError("stiffness", stiffness, accepted) from None
        if self.stiffness.ndim > 2 or not np.all(np.isfinite(self.stiffness)):
            raise ArgumentError("stiffness", stiffness, accepted)

    def weight(self, rows: int) -> Array:
        """The stiffness Kp as a matrix (rows, rows).

        Raises:
            ArgumentError: when it has another size or is not symmetric positive definite.
        """
        accepted = f"a positive scalar, {rows} positive values, or a symmetric positive definite ({rows}, {rows})"
        K = self.stiffness
        if K.ndim == 0:
            K = K * np.eye(rows)
        elif K.shape == (rows,):
            K = np.diag(K)
        if K.shape != (rows, rows) or not np.allclose(K, K.T, rtol=1e-12, atol=0):
            raise ArgumentError("stiffness", self.stiffness, accepted)
        if np.linalg.eigvalsh(K)[0] <= 0:
            raise ArgumentError("stiffness", self.stiffness, accepted)
        return np.asarray(K)


def named(axes: Axes) -> tuple[str, ...] | None:
    """``axes`` as a tuple. Raises ArgumentError when it is neither names nor None."""
    if axes is None or isinstance(axes, (str, Sequence)):
        return None if axes is None else tuple(axes)
    raise ArgumentError("axes", axes, "names of rows such as 'xy' or ('x', 'rz'), or None for all")


def kept(axes: tuple[str, ...] | None, names: Sequence[str], of: str = "") -> list[int]:
    """Indices of ``axes`` in ``names``, all for None. Raises ArgumentError for unknown, repeated or no axes."""
    if axes is None:
        return list(range(len(names)))
    if not axes or len(set(axes)) != len(axes) or not set(axes) <= set(names):
        raise ArgumentError("axes", axes, f"distinct names from {list(names)}{of}")
    return [names.index(axis) for axis in axes]
