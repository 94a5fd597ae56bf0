"""The collection: problems from papers and examples, whose answers are known."""

from __future__ import annotations

from collections.abc import Callable

from jtik.errors import UnknownNameError
from jtik.problems.collection import planar, spatial, worked
from jtik.problems.collection.named import Named

__all__ = ["Named", "named", "names"]

_ENTRIES: tuple[Callable[[], Named], ...] = (
    worked.sns_4r,
    worked.transpose_step_2r,
    worked.null_projector_3r,
    planar.das1988_families,
    planar.centering_3r,
    planar.straight_10r,
    planar.elbow_2r,
    planar.unreachable_10r,
    planar.circle_3r,
    planar.circle_10r,
    spatial.panda_stretched,
    spatial.ur5e_wrist,
    spatial.circle_panda,
)
_NAMED = {build.__name__: build for build in _ENTRIES}


def names() -> tuple[str, ...]:
    """The names that `named` knows."""
    return tuple(_NAMED)


def named(name: str) -> Named:
    """Robot, task, criteria and problems of the collection's entry of that name, built anew.

    Raises:
        UnknownNameError: when there is no such entry; it suggests the closest name.
    """
    if name not in _NAMED:
        raise UnknownNameError("problem", name, _NAMED)
    return _NAMED[name]()
