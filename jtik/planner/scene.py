"""The obstacles of a plan as the loop keeps them: named, immutable, with a gain each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Self

from jtik.errors import ArgumentError, UnknownNameError
from jtik.geometry import Circle, Obstacle, Point, Sphere

SHAPES = {"point": Point, "circle": Circle, "sphere": Sphere}


def obstacle_of(data: Mapping[str, Any]) -> Obstacle:
    """The obstacle of plain data."""
    given = dict(data)
    shape = given.pop("shape", None)
    if shape not in SHAPES:
        raise ArgumentError("obstacle", f"shape {shape!r}", f"one of the shapes {', '.join(SHAPES)}")
    try:
        made: Obstacle = SHAPES[shape](**given)
    except TypeError:
        raise ArgumentError("obstacle", dict(data), f"a {shape} with its own numbers") from None
    return made


@dataclass(frozen=True, eq=False)
class Scene:
    """Obstacles by name."""

    obstacles: Mapping[str, Obstacle] = field(default_factory=dict)
    gains: Mapping[str, float] = field(default_factory=dict)

    def with_(self, name: str, obstacle: Obstacle, gain: float = 1.0) -> Self:
        return replace(self, obstacles={**self.obstacles, name: obstacle}, gains={**self.gains, name: gain})

    def without(self, name: str) -> Self:
        if name not in self.obstacles:
            raise UnknownNameError("obstacle", name, self.obstacles)
        return replace(
            self,
            obstacles={key: value for key, value in self.obstacles.items() if key != name},
            gains={key: value for key, value in self.gains.items() if key != name},
        )

    def to_dict(self) -> dict[str, Any]:
        return {
            name: {
                "shape": type(each).__name__.lower(),
                "center": each.center.tolist(),
                "radius": each.radius,
                "gain": self.gains[name],
            }
            for name, each in self.obstacles.items()
        }
