"""The places for obstacles in a solver: which scenes have room, and how many places another solver should have."""

from __future__ import annotations

import math

import numpy as np

from jtik.errors import ArgumentError
from jtik.geometry import Polygon, Scene, Slots, Solid
from jtik.geometry.slots import CORNERS


def has_room(slots: Slots, scene: Scene) -> bool:
    """Whether every obstacle has a place."""
    try:
        slots.parameters(scene)
    except ArgumentError:
        return False
    return True


def part(slots: Slots, scene: Scene) -> Scene:
    """The obstacles that have a place, the first ones of each kind."""
    if has_room(slots, scene):
        return scene
    kept = Scene()
    for name in scene.names:
        more = kept.with_(name, scene[name], scene.gains[name])
        kept = more if has_room(slots, more) else kept
    return kept


def grown(slots: Slots, scene: Scene) -> Slots:
    """Places for every obstacle and some more: twice as many of each kind that is short of them."""
    needed = Slots.of(scene, len(scene) or 1, slots.dimension)
    counts = {
        kind: have if needed.counts[kind] <= have else max(4, 2 * have, needed.counts[kind])
        for kind, have in slots.counts.items()
    }
    return Slots(counts, slots.dimension, max(slots.corners, needed.corners))


def placeholders(slots: Slots) -> tuple[Solid, ...]:
    """Obstacles to build a criterion with: where polygons have many corners, one that has as many."""
    if slots.corners <= CORNERS or not slots.counts["polygon"]:
        return ()
    angles = np.arange(slots.corners) * (2 * math.pi / slots.corners)
    return (Polygon(np.stack([np.cos(angles), np.sin(angles)], axis=1)),)
