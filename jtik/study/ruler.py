"""What else is measured at a configuration: H, V, the condition of the task, and the distance to obstacles."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jtik._step.symbolic_problem import SymbolicProblem
from jtik.constraints.clearance import Clearance, Measure
from jtik.criterion import Criterion, CriterionSum, CriterionTerms, Parameters
from jtik.robot import Robot
from jtik.symbolic import dot, function, mmin, vertcat
from jtik.symbolic.compile import CompiledFunction
from jtik.task import TaskStack
from jtik.types import Array


@dataclass
class NamedMeasure:
    """What measures distances, under the name that its parameters have in a study."""

    name: str
    measure: Measure

    def parameters(self, robot: Robot) -> Mapping[str, ArrayLike]:
        """The measure's own."""
        return self.measure.parameters(robot)


def measures_of(criteria: Criterion | CriterionSum | None, clearances: Iterable[Clearance]) -> list[NamedMeasure]:
    """Everything there that can tell distances to obstacles."""
    named = [(name, criterion) for name, _, criterion in CriterionSum.of(criteria).named()]
    found = [NamedMeasure(name, criterion) for name, criterion in named if isinstance(criterion, Measure)]
    return found + [NamedMeasure(clearance.name, clearance.measure) for clearance in clearances]


class Ruler:
    """Measures configurations of one robot with one set of criteria.

    Args:
        robot: the robot that configurations belong to.
        tasks: the tasks on it.
        criteria: what H is.
        measures: what tells distances to obstacles.

    Raises:
        CriterionError: for a criterion that cannot be used.
    """

    def __init__(
        self,
        robot: Robot,
        tasks: TaskStack,
        criteria: Criterion | CriterionSum | None,
        measures: Iterable[NamedMeasure] = (),
    ) -> None:
        terms = CriterionTerms.of(robot, criteria)
        problem = SymbolicProblem(robot, tasks, terms, ())
        q, target, column = problem.symbols()
        residual = problem.residual(q, target)
        outputs = [problem.criterion(q, column), dot(residual, residual) / 2, problem.error_jacobian(q, target)]
        self._measured = CompiledFunction(function("ruler", [q, target, column], outputs))
        self._has_criterion = problem.has_criterion
        measures = list(measures)
        distances = CriterionTerms.of(robot, None, measures)
        self._distances: CompiledFunction | None = None
        if measures:
            column, bodies = distances.parameters.symbols(), []
            for each in measures:
                own = distances.own(each, column)
                bodies += [d for body in each.measure.distances(robot.at(q), own) for d in body]
            self._distances = CompiledFunction(function("clearance", [q, column], [mmin(vertcat(*bodies))]))
        self._live = [terms.parameters, distances.parameters]
        self._first = [dict(each) for each in self._live]

    @property
    def parameters(self) -> dict[str, Array]:
        """Live parameters of criteria and distances, with their present values."""
        return {name: value for each in self._live for name, value in each.items()}

    def set(self, parameters: Mapping[str, Array]) -> None:
        """These values; parameters that are not named get their first ones back."""
        for live, first in zip(self._live, self._first, strict=True):
            for name, value in first.items():
                live[name] = parameters.get(name, value)

    def at(self, q: Array, numbers: Array) -> tuple[float, float, float]:
        """H, V, and the condition number of the task's Jacobian at q; NaN for H where there is no criterion."""
        H, V, J = self._measured(q, numbers, self._live[0].memory)
        return float(H[0, 0]) if self._has_criterion else float("nan"), float(V[0, 0]), condition(J)

    def clearance(self, configurations: Iterable[Array]) -> float:
        """The least distance [m] to an obstacle at any of them; NaN where nothing measures any."""
        if self._distances is None:
            return float("nan")
        memory = self._live[1].memory
        return min((float(self._distances(q, memory)[0][0, 0]) for q in configurations), default=float("nan"))


def condition(J: Array) -> float:
    """Ratio of the singular values of a Jacobian; infinite at a singular pose, NaN where it is not finite."""
    if not np.isfinite(J).all():
        return float("nan")
    sigma: Any = np.linalg.svd(J, compute_uv=False)
    return float(sigma[0] / sigma[-1]) if sigma[-1] > np.finfo(float).eps * sigma[0] else float("inf")


__all__ = ["NamedMeasure", "Parameters", "Ruler", "condition", "measures_of"]
