"""Collection of problems from papers and examples whose solutions are known."""

from __future__ import annotations

from collections.abc import Callable

from jtik.arguments import text
from jtik.errors import UnknownNameError
from jtik.problems.collection import planar, spatial, worked
from jtik.problems.collection.named_problem import NamedProblem

__all__ = ["NamedProblem", "named", "names"]

_ENTRIES: tuple[Callable[[], NamedProblem], ...] = (
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
    """Names of the problems in the collection."""
    return tuple(_NAMED)


def named(name: str) -> NamedProblem:
    """A problem of the collection by name: its robot, task, criteria and cases.

    Args:
        name: name of the problem, one of `names`.

    Raises:
        UnknownNameError: for an unknown name; it suggests the closest one.
    """
    if text("name", name, "the name of a problem") not in _NAMED:
        raise UnknownNameError("problem", name, _NAMED)
    return _NAMED[name]()
