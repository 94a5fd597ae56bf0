"""Rotation matrices from rotation vectors."""

from __future__ import annotations

import numpy as np

from jtik.types import Array


def rotation_about(vector: Array) -> Array:
    """Rotation matrix (3, 3) of the rotation vector ``vector`` (3,) [rad], by Rodrigues' formula."""
    angle = float(np.linalg.norm(vector))
    if angle == 0:
        return np.eye(3)
    x, y, z = vector / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    rotation: Array = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * (cross @ cross)
    return rotation
