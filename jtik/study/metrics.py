"""Metrics of a configuration: H, V, the condition number of the task, and the distance to obstacles."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jtik._step.symbolic_problem import SymbolicProblem
from jtik.constraints.clearance import Clearance
from jtik.constraints.measure import Measure
from jtik.criterion import Criterion, CriterionSum, CriterionTerms, Parameters
from jtik.robot import Robot
from jtik.symbolic import dot, function, mmin, vertcat
from jtik.symbolic.compile import CompiledFunction
from jtik.task import TaskStack
from jtik.types import Array


@dataclass
class NamedMeasure:
    """A distance measure with the name that prefixes its parameters.

    Attributes:
        name: name of the criterion or clearance.
        measure: the distance measure.
    """

    name: str
    measure: Measure

    def parameters(self, robot: Robot) -> Mapping[str, ArrayLike]:
        """Parameters of the measure."""
        return self.measure.parameters(robot)


def measures_of(criteria: Criterion | CriterionSum | None, clearances: Iterable[Clearance]) -> list[NamedMeasure]:
    """All criteria and clearances that measure distances to obstacles."""
    named = [(name, criterion) for name, _, criterion in CriterionSum.of(criteria).named()]
    found = [NamedMeasure(name, criterion) for name, criterion in named if isinstance(criterion, Measure)]
    return found + [NamedMeasure(clearance.name, clearance.measure) for clearance in clearances]


class ConfigurationMetrics:
    """Metrics of configurations of one robot with one set of criteria.

    Args:
        robot: the reduced robot.
        tasks: the tasks on it.
        criteria: the criteria, whose weighted sum is H.
        measures: the measures of distances to obstacles.

    Raises:
        CriterionError: for an invalid criterion.
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
        self._measured = CompiledFunction(function("metrics", [q, target, column], outputs))
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
        """Current values of the live parameters of criteria and distance measures."""
        return {name: value for each in self._live for name, value in each.items()}

    def set(self, parameters: Mapping[str, Array]) -> None:
        """Set live parameters; those that are not given return to their first values."""
        for live, first in zip(self._live, self._first, strict=True):
            for name, value in first.items():
                live[name] = parameters.get(name, value)

    def at(self, q: Array, numbers: Array) -> tuple[float, float, float]:
        """H, V and the condition number of the task Jacobian at q; H is NaN without a criterion."""
        H, V, J = self._measured(q, numbers, self._live[0].memory)
        return float(H[0, 0]) if self._has_criterion else float("nan"), float(V[0, 0]), condition(J)

    def clearance(self, configurations: Iterable[Array]) -> float:
        """The smallest distance to an obstacle over the configurations [m]; NaN without a distance measure."""
        if self._distances is None:
            return float("nan")
        memory = self._live[1].memory
        return min((float(self._distances(q, memory)[0][0, 0]) for q in configurations), default=float("nan"))


def condition(J: Array) -> float:
    """Ratio of largest to smallest singular value; infinite for a singular Jacobian, NaN for a non-finite one."""
    if not np.isfinite(J).all():
        return float("nan")
    sigma: Any = np.linalg.svd(J, compute_uv=False)
    return float(sigma[0] / sigma[-1]) if sigma[-1] > np.finfo(float).eps * sigma[0] else float("inf")


__all__ = ["ConfigurationMetrics", "NamedMeasure", "Parameters", "condition", "measures_of"]
