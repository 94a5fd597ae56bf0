"""Inverse kinematics problems for comparing strategies: seeded generators, and a collection with known solutions.

A generator draws a `ProblemSet` for any robot and task. `named` returns problems from papers and examples whose
solutions are known. The same arguments give the same set. `boundary`, `near_singular` and the path generators use a
solver to decide whether a target can be reached. Another version of the solver may decide differently, so a set can be
saved as data.
"""

import warnings
from typing import Any

from jtik.problems.boundary import boundary
from jtik.problems.case import Case, ProblemSet
from jtik.problems.circle import circle
from jtik.problems.collection import NamedProblem, named, names
from jtik.problems.five_families import five_families
from jtik.problems.line import line
from jtik.problems.lissajous import lissajous
from jtik.problems.near_limits import near_limits
from jtik.problems.near_singular import near_singular
from jtik.problems.path import path
from jtik.problems.reachable import reachable
from jtik.problems.scene import obstacles_of, scene
from jtik.problems.unreachable import unreachable

__all__ = [
    "Case",
    "NamedProblem",
    "ProblemSet",
    "boundary",
    "circle",
    "five_families",
    "line",
    "lissajous",
    "named",
    "names",
    "near_limits",
    "near_singular",
    "obstacles_of",
    "path",
    "reachable",
    "scene",
    "unreachable",
]


def __getattr__(name: str) -> Any:
    if name == "Named":
        warnings.warn("jtik.problems.Named is now jtik.problems.NamedProblem", DeprecationWarning, stacklevel=2)
        return NamedProblem
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
