"""The options that all tasks of jtik share: stiffness, priority, name, and the rows to keep."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from jtik.arguments import array_of, integer, names, several
from jtik.arguments import name as read_name
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
        self.priority = integer("priority", priority, accepted="a non-negative integer; 0 is the highest level")
        self.name = read_name("name", name)
        accepted = "a positive scalar, a positive value for each row, or a symmetric positive definite matrix"
        self.stiffness = array_of("stiffness", stiffness, [(), (None,), (None, None)], accepted)
        rows, *columns = self.stiffness.shape or (1,)
        positive = bool(columns) or bool((self.stiffness > 0).all())
        if not rows or columns not in ([], [rows]) or not positive:
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
    accepted = "distinct names from x, y, z, rx, ry, rz, such as 'xy' or ('x', 'rz'), or None for all"
    if axes is None:
        return None
    chosen = names("axes", tuple(axes) if isinstance(axes, str) else several("axes", axes, accepted), accepted)
    if not chosen:
        raise ArgumentError("axes", axes, accepted)
    return chosen


def kept(axes: tuple[str, ...] | None, names: Sequence[str], of: str = "") -> list[int]:
    """Indices of ``axes`` in ``names``, all for None. Raises ArgumentError for unknown, repeated or no axes."""
    if axes is None:
        return list(range(len(names)))
    if not axes or len(set(axes)) != len(axes) or not set(axes) <= set(names):
        raise ArgumentError("axes", axes, f"distinct names from {list(names)}{of}")
    return [names.index(axis) for axis in axes]
