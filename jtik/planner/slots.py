"""The places for obstacles in a compiled solver: which scenes fit, and their values as live parameters."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from jtik.geometry import Circle, Obstacle, Sphere
from jtik.planner.scene import Scene
from jtik.types import Array

FAR = 1e6
"""Where an unused place is [m]."""


class Slots:
    """Places for balls."""

    def __init__(self, count: int, dimension: int) -> None:
        self.count, self.dimension = count, dimension

    @property
    def capacity(self) -> Mapping[str, int]:
        return {"ball": self.count}

    def fits(self, scene: Scene) -> bool:
        return len(scene.obstacles) <= self.count

    def part(self, scene: Scene) -> Scene:
        for name in list(scene.obstacles)[self.count :]:
            scene = scene.without(name)
        return scene

    def grown(self, scene: Scene) -> Slots:
        count = self.count
        while count < len(scene.obstacles):
            count *= 2
        return Slots(count, self.dimension)

    def placeholders(self) -> list[Obstacle]:
        kind: Any = Circle if self.dimension == 2 else Sphere
        return [kind(np.full(self.dimension, FAR), 0.0)] * self.count

    def values(self, scene: Scene) -> dict[str, Array]:
        centers, radii = np.full((self.count, self.dimension), FAR), np.zeros(self.count)
        used = [name for name in scene.obstacles if scene.gains[name] > 0]
        for i, name in enumerate(used):
            centers[i], radii[i] = scene.obstacles[name].center, scene.obstacles[name].radius
        return {"centers": centers, "radii": radii}
