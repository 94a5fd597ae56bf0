"""What the clearances of a problem measure: distances, their Jacobian and their figures as functions.

Distances of few pairs are written out, operation by operation, and share what they can. Of a measure with many there
are loops over its pairs: text, and time to build and to compile, do not grow with them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jtik.constraints.clearance import Clearance
from jtik.constraints.many_distances import ManyDistances
from jtik.constraints.measure import pair_names, rounding_of
from jtik.criterion import CriterionTerms
from jtik.criterion.overriding import belongs_to
from jtik.qp.shared_values import divided
from jtik.robot import Kinematics
from jtik.symbolic import MX, SX, TINY, Expression, Function, fmax, function, horzcat, jacobian, reshape, vertcat

Rows = Callable[[Expression, Expression], list[Expression]]
"""(q, parameters) -> distances, their Jacobian and their figures."""

Bodies = tuple[Function, list[Function]]
"""(q, parameters) -> what several bodies need, a column; and for each body (q, parameters, that) -> its distances."""


@dataclass(frozen=True)
class Measurement:
    """The distances of all clearances.

    Attributes:
        distances: (q, parameters) -> the distances (k, 1) [m].
        clearance: (q, parameters) -> distances, their Jacobian (k, n), safe, aim, influence, gain and radius (k, 5).
        bodies: the distances by body, or by measure where there are loops over its pairs.
        pairs: name of each distance.
        sizes: number of distances of each function of ``bodies``, in their order.
        restored: whether each distance is restored when it is too small, (k,).
        rows: what ``clearance`` returns for matrix expressions of its arguments; None without loops over pairs.
    """

    distances: Function
    clearance: Function
    bodies: Sequence[Bodies]
    pairs: Sequence[str]
    sizes: Sequence[int]
    restored: NDArray[np.bool_]
    rows: Rows | None

    @classmethod
    def of(
        cls, clearances: Sequence[Clearance], terms: CriterionTerms, kinematics: Kinematics, parameters: Expression
    ) -> Measurement:
        """What clearances measure.

        Args:
            clearances: the clearances.
            terms: the terms of the problem, which know the live parameters of each clearance.
            kinematics: the robot at symbols of q.
            parameters: symbols of all live parameters.

        Raises:
            ArgumentError: where a measure has no bound for a distance.
        """
        parts = [_Part.of(each, terms, kinematics, parameters) for each in clearances]
        rows = None
        if any(part.many for part in parts):
            distances, rows, bodies = _looped(parts, kinematics, parameters)
            given = [MX.sym(f"i{i}", *distances.size_in(i)) for i in range(distances.n_in())]
            clearance = function("clearance", given, rows(*given), cse=False, inline=False)
        else:
            distances, clearance, bodies = _written_out(parts, kinematics, parameters)
        return cls(
            distances,
            clearance,
            bodies,
            pairs=[pair for part in parts for pair in part.pairs],
            sizes=[size for part in parts for size in (part.many.sizes if part.many else part.sizes) if size],
            restored=np.concatenate([np.full(part.count, part.clearance.restore) for part in parts]),
            rows=rows,
        )


@dataclass(frozen=True)
class _Part:
    """What one clearance measures.

    Attributes:
        clearance: the clearance.
        many: functions of its distances, where they are many.
        bodies: otherwise the distances of each body.
        linear: the distances (k, 1) and their Jacobian by q where the measure has its own; else None.
        figures: safe, aim, influence and gain.
        rounding: for each distance the radius of the set that it is measured to [m].
        pairs: name of each distance.
    """

    clearance: Clearance
    many: ManyDistances | None
    bodies: Sequence[Sequence[Expression]]
    linear: tuple[Expression, Expression] | None
    figures: tuple[Expression, ...]
    rounding: Sequence[Expression]
    pairs: Sequence[str]

    @classmethod
    def of(cls, clearance: Clearance, terms: CriterionTerms, kinematics: Kinematics, parameters: Expression) -> _Part:
        robot, own = kinematics.robot, terms.own(clearance, parameters)
        given = clearance.of_measure(robot, own)
        measure: Any = clearance.measure  # its optional methods are not those of its type
        many = linear = None
        if all(belongs_to(measure, "many", other) for other in ("distances", "linearized")):
            found = measure.many(kinematics, given, parameters)
            many = found if found.are_many else None
        if many:
            bodies = [[None] * count for count in many.bodies]
        else:
            bodies = measure.distances(kinematics, given)
            if belongs_to(measure, "linearized", "distances"):
                linear = measure.linearized(kinematics, given)
        rounding = list(chain(*rounding_of(measure, robot, given, bodies)))
        figures = (own["safe"], own["safe"] + clearance.margin, own["influence"], clearance.gain)
        return cls(clearance, many, bodies, linear, figures, rounding, pair_names(clearance, robot, bodies))

    @property
    def sizes(self) -> list[int]:
        """Number of distances of each body."""
        return [len(body) for body in self.bodies]

    @property
    def count(self) -> int:
        """Number of distances."""
        return sum(self.sizes)

    def radius(self, rounding: Expression) -> Expression:
        """The smallest radius of curvature of the surface at the safe distance [m], of a set with this rounding."""
        return fmax(self.figures[0] + rounding, TINY)

    def row_figures(self, parameters: Expression) -> Function:
        """parameters -> the figures of each distance (k, 5)."""
        rounding = [SX(each) for each in self.rounding]  # whose hashes are those of objects that exist
        keys = [each.element_hash() for each in rounding]
        distinct = dict(zip(keys, rounding, strict=True))
        places = {key: i for i, key in enumerate(distinct)}
        radii = [self.radius(each) for each in distinct.values()]
        given = MX.sym("parameters", parameters.shape[0])
        row, column = function("figures", [parameters], [horzcat(*self.figures), vertcat(*radii)])(given)
        shared = row.shape[1]
        entries = [i for i in range(shared) for _ in range(self.count)] + [shared + places[key] for key in keys]
        rows = reshape(vertcat(row.T, column)[entries], self.count, shared + 1)
        return function("row_figures", [given], [rows], cse=False)

    def written_out(self, q: Expression, parameters: Expression, tangent: Expression) -> tuple[Function, Bodies]:
        """(q, parameters) -> distances, Jacobian by the velocity; and its bodies."""
        groups = [vertcat(*body) for body in self.bodies if body]
        distances = vertcat(*groups)
        found, J = self.linear or (distances, jacobian(distances, q))
        linearized = function("linearized", [q, parameters], [found, J @ tangent])
        return linearized, divided("distances", [q, parameters], groups)


def _written_out(
    parts: Sequence[_Part], kinematics: Kinematics, parameters: Expression
) -> tuple[Function, Function, list[Bodies]]:
    q, tangent = kinematics.q, kinematics.robot.tangent(kinematics.q)
    groups = [vertcat(*body) for part in parts for body in part.bodies if body]
    measured = function("distances", [q, parameters], [vertcat(*groups)])
    d = measured(q, parameters)  # where each value is computed once
    columns, jacobians, figures, start = [], [], [], 0
    for part in parts:
        derived = d[start : start + part.count]
        found, J = part.linear or (derived, jacobian(derived, q))
        columns.append(found)
        jacobians.append(J)
        figures += [horzcat(*part.figures, part.radius(rounding)) for rounding in part.rounding]
        start += part.count
    outputs = [vertcat(*columns), vertcat(*jacobians) @ tangent, vertcat(*figures)]
    shared = any(part.linear for part in parts)
    clearance = function("clearance", [q, parameters], outputs, cse=shared)
    ends = np.cumsum([size for part in parts for size in part.sizes if size]).tolist()
    own = [d[start:end] for start, end in zip([0, *ends], ends, strict=False)]
    return measured, clearance, [divided("distances", [q, parameters], own)]


def _looped(
    parts: Sequence[_Part], kinematics: Kinematics, parameters: Expression
) -> tuple[Function, Rows, list[Bodies]]:
    symbols, tangent = (kinematics.q, parameters), kinematics.robot.tangent(kinematics.q)
    q, live = (MX.sym(f"i{i}", each.shape[0]) for i, each in enumerate(symbols))
    written = [None if part.many else part.written_out(*symbols, tangent) for part in parts]
    figures = [part.row_figures(parameters) for part in parts]

    def rows(at: Expression, given: Expression) -> list[Expression]:
        found = []
        for part, own, of_part in zip(parts, written, figures, strict=True):
            measured = own[0](at, given) if own else part.many.linearized(at, given, tangent)  # type: ignore[union-attr]
            found.append([*measured, of_part(given)])
        return [vertcat(*column) for column in zip(*found, strict=True)]

    bodies, distances = list[Bodies](), []
    for part, own in zip(parts, written, strict=True):
        shared, functions = own[1] if own else (part.many.shared, part.many.own)  # type: ignore[union-attr]
        bodies.append((shared, functions))
        values = shared(q, live)
        distances += [body(q, live, values) for body in functions]
    measured = function("distances", [q, live], [vertcat(*distances)], cse=False, inline=False)
    return measured, rows, bodies
