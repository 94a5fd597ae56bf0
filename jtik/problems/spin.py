"""A rotation as a matrix."""

from __future__ import annotations

import numpy as np

from jtik.types import Array


def turn(vector: Array) -> Array:
    """The rotation (3, 3) about ``vector`` (3,) by its length [rad] (Rodrigues)."""
    angle = float(np.linalg.norm(vector))
    if angle == 0:
        return np.eye(3)
    x, y, z = vector / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    turned: Array = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * (cross @ cross)
    return turned
