"""Masses and inertias on the frames, for statics and dynamics, and shapes on the frames, for clearances."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from jtik.arguments import finite_array, mapping, non_negative_number, several
from jtik.constructors import Constructed
from jtik.errors import ArgumentError, UnknownNameError
from jtik.geometry import Ball, Box, Capsule, Cylinder, Solid
from jtik.robot.tree import frozen
from jtik.types import Array

ROUNDING = 1e-9
"""Asymmetry and negative principal moment of an inertia, relative to its largest entry, that count as rounding."""

NEGLIGIBLE = 1e-15
"""Asymmetry and negative principal moment of an inertia that always count as rounding [kg m^2]."""


@dataclass(frozen=True, eq=False)
class Mass(metaclass=Constructed):
    """The mass and the inertia of what a frame carries.

    Attributes:
        mass: non-negative mass [kg].
        center: position of the centre of mass in its frame, (3,) [m].
        inertia: inertia tensor about the centre of mass, in the axes of the frame, (3, 3) [kg m^2]; zero, a point mass,
            by default. Its off-diagonal entries are ixy = -(integral of x y dm), as in URDF and MuJoCo.

    Raises:
        ArgumentError: when a value is not finite, the mass is negative, or the tensor is not symmetric, has a
            negative principal moment, or is not zero where the mass is.
    """

    mass: float
    center: Array = field(default_factory=lambda: np.zeros(3))
    inertia: Array = field(default_factory=lambda: np.zeros((3, 3)))

    def __post_init__(self) -> None:
        object.__setattr__(self, "mass", non_negative_number("Mass.mass", self.mass, "a non-negative mass [kg]"))
        object.__setattr__(self, "center", frozen(finite_array("Mass.center", self.center, (3,))))
        inertia = finite_array("Mass.inertia", self.inertia, (3, 3))
        if not is_inertia(inertia):
            accepted = "a symmetric (3, 3) tensor [kg m^2] without negative principal moments"
            raise ArgumentError("Mass.inertia", inertia.tolist(), accepted)
        if self.mass == 0 and inertia.any():
            raise ArgumentError("Mass.inertia", inertia.tolist(), "zeros beside a mass of zero")
        object.__setattr__(self, "inertia", frozen((inertia + inertia.T) / 2))

    def __reduce__(self) -> tuple[Any, ...]:
        return partial(type(self), self.mass, self.center, self.inertia), ()


def is_inertia(tensor: Array) -> bool:
    """Whether a finite tensor (3, 3) is symmetric and has no negative principal moment, up to rounding."""
    rounding = max(ROUNDING * float(np.abs(tensor).max()), NEGLIGIBLE)
    if np.abs(tensor - tensor.T).max() > rounding:
        return False
    return bool(np.linalg.eigvalsh((tensor + tensor.T) / 2)[0] >= -rounding)


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
