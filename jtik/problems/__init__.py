"""Problems to compare strategies on: generators of seeded sets, and a collection with known answers.

A generator draws a `ProblemSet` for any robot and task; `named` gives problems from papers and examples, whose answers
are known. The same arguments draw the same set; where a solver decides whether a target can be reached (`boundary`,
`near_singular`, paths), another version of the solver may decide otherwise, which is why a set can be saved as data.
"""

from jtik.problems.boundary import boundary
from jtik.problems.case import Case, ProblemSet
from jtik.problems.circle import circle
from jtik.problems.collection import Named, named, names
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
    "Named",
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
