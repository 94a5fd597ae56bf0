"""Masses on the frames, for the centre of mass, and shapes on the frames, for clearances."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from jtik.arguments import finite_array, mapping, non_negative_number, several
from jtik.errors import ArgumentError, UnknownNameError
from jtik.geometry import Ball, Box, Capsule, Cylinder, Solid
from jtik.robot.tree import frozen
from jtik.types import Array


@dataclass(frozen=True, eq=False)
class Mass:
    """A point mass on a frame, for the centre of mass.

    Attributes:
        mass: non-negative mass [kg].
        center: position in its frame, (3,) [m].
    """

    mass: float
    center: Array = field(default_factory=lambda: np.zeros(3))

    def __post_init__(self) -> None:
        object.__setattr__(self, "mass", non_negative_number("Mass.mass", self.mass, "a non-negative mass [kg]"))
        object.__setattr__(self, "center", frozen(finite_array("Mass.center", self.center, (3,))))

    def __reduce__(self) -> tuple[Any, ...]:
        return partial(type(self), self.mass, self.center), ()


def masses_on(frames: Sequence[str], masses: Mapping[str, Mass] | None) -> dict[str, Mass]:
    """The masses by frame, without those that are zero; raises UnknownNameError for a frame that does not exist."""
    given = {} if masses is None else mapping("masses", masses, "a dict from frame to jtik.robot.Mass, or None")
    for frame, mass in given.items():
        _check_frame("mass", frame, frames)
        if not isinstance(mass, Mass):
            raise ArgumentError(f"masses[{frame!r}]", mass, "a jtik.robot.Mass")
    return {frame: mass for frame, mass in given.items() if mass.mass > 0}


def shapes_on(frames: Sequence[str], shapes: Mapping[str, Sequence[Solid]] | None) -> dict[str, tuple[Solid, ...]]:
    """The shapes by frame; raises UnknownNameError for a frame that does not exist."""
    accepted = "a jtik.Sphere, Capsule, Cylinder or Box"
    named = (
        {} if shapes is None else mapping("shapes", shapes, f"a dict from frame to a list, each {accepted}; or None")
    )
    given = {
        frame: several(f"shapes[{frame!r}]", solids, f"a list, each {accepted}") for frame, solids in named.items()
    }
    for frame, solids in given.items():
        _check_frame("shape", frame, frames)
        for solid in solids:
            if not isinstance(solid, (Ball, Box, Capsule, Cylinder)):
                raise ArgumentError(f"shapes[{frame!r}]", solid, accepted)
    return {frame: solids for frame, solids in given.items() if solids}


def _check_frame(what: str, frame: str, frames: Sequence[str]) -> None:
    if frame not in frames:
        raise UnknownNameError(f"frame of a {what}", frame, frames)
