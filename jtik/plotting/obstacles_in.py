"""Obstacles as they are in live parameters of criteria and clearances."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from jtik.geometry import Circle, Solid, Sphere


def obstacles_in(parameters: Mapping[str, Any]) -> tuple[Solid, ...]:
    """The obstacles of criteria and clearances, each once.

    Args:
        parameters: live parameters by name, such as ``ik.parameters``.
    """
    found: dict[bytes, Solid] = {}
    for name in parameters:
        owner, _, last = name.rpartition(".")
        if last != "centers" or f"{owner}.radii" not in parameters:
            continue
        centers, radii = np.asarray(parameters[name]), np.asarray(parameters[f"{owner}.radii"])
        kind = Circle if centers.shape[1] == 2 else Sphere
        for center, radius in zip(centers, radii.ravel().tolist(), strict=True):
            found.setdefault(np.append(center, radius).tobytes(), kind(center, radius))
    return tuple(found.values())
