"""Solvers of the planner: built in a worker while another one goes on, and filled with the present values."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Mapping
from concurrent.futures import Executor, Future
from dataclasses import replace
from typing import Any

from jtik.constraints import Clearance, Limits
from jtik.criterion import CriterionSum
from jtik.errors import ArgumentError
from jtik.geometry import Slots
from jtik.planner.session import catalogue
from jtik.planner.session.measure import Gauge
from jtik.planner.session.settings import Problem, Structure, Values
from jtik.planner.session.slots import part, placeholders
from jtik.result import Step
from jtik.solver import InverseKinematics
from jtik.strategy import Strategy
from jtik.types import Array

AVOIDANCE = "obstacle_avoidance"
"""The criterion by whose distances clearances are kept and measured."""

KEPT = 4
"""Number of solvers that are kept for when the operator returns to them."""

GIVEN = "given"
"""Name of the strategy that was given as an object."""

PREFERRED = ".preferred"
"""What the name of a live parameter ends with that is a preferred posture."""


class Solver:
    """A solver for one structure.

    Args:
        problem: what stays as it is.
        structure: what it is built for.

    Attributes:
        structure: what it is built for.
        ik: the solver.
        gauge: measures distances to the obstacles.

    Raises:
        JtikError: where there is none for that structure.
    """

    def __init__(self, problem: Problem, structure: Structure) -> None:
        self.structure = structure
        common = _common(problem, structure.slots)
        terms = [(problem.weights.get(name, 1.0), problem.criteria.make(name, common)) for name in structure.criteria]
        criteria = CriterionSum(tuple(terms))
        links = measured(problem.bodies)[1]  # joints are the ends of links
        clearance = Clearance(_measure(problem, common, links)) if structure.clearance else None
        self.ik = InverseKinematics(
            problem.robot,
            problem.tasks,
            criteria=criteria,
            strategy=_strategy(problem, structure),
            limits=_limits(problem.limits, structure.limits),
            clearances=clearance,
            weights=structure.joint_weights,
            compiled=problem.compiled,
        )
        self.ik.warm_up()
        self.ik.jog(self.ik.robot.home, 0.0)  # which builds its functions
        self.gauge = Gauge(self.ik.robot, [_measure(problem, common, bodies) for bodies in measured(problem.bodies)])
        parts = [(name, criterion) for name, _, criterion in criteria.named()]
        parts += [("clearance", clearance.measure)] if clearance else []  # type: ignore[list-item]  # has slots, too
        self._places = {name: each.slots(self.ik.robot) for name, each in parts if hasattr(each, "slots")}
        self._places = {name: slots for name, slots in self._places.items() if slots.gains}
        self._of_scene = {f"{name}.{key}" for name, slots in self._places.items() for key in slots.parameters(())}
        self._preferred = [name for name in self.ik.parameters if name.endswith(PREFERRED)]

    @property
    def gains(self) -> dict[str, Array]:
        """The live parameters that an operator sets by name, with their values: all but obstacles and postures."""
        return {
            name: value
            for name, value in self.ik.parameters.items()
            if name not in self._of_scene and name not in self._preferred
        }

    def set_gain(self, name: str, value: Any) -> None:
        """Set one live parameter. Raises JtikError for a name or a value that it does not accept."""
        if name in self._of_scene or name in self._preferred:
            raise ArgumentError("parameter", name, f"one of {', '.join(self.gains)}")
        self.ik.parameters[name] = value

    def fill(self, values: Values) -> None:
        """Set every live parameter."""
        parameters = self.ik.parameters
        self.fill_scene(values)
        for name in self._preferred:
            if parameters.shapes[name] == values.preferred.shape:
                parameters[name] = values.preferred
        for name, value in values.gains.items():
            if name in parameters:
                parameters[name] = value
        if self.structure.clearance:
            parameters["clearance.safe"] = values.safe

    def fill_scene(self, values: Values) -> None:
        """Set the obstacles."""
        for holder, slots in self._places.items():
            scene = part(slots, values.scene)
            for name, value in slots.parameters(scene, list(scene.gains.values())).items():
                self.ik.parameters[f"{holder}.{name}"] = value
        slots = self.structure.slots
        scene = part(slots, values.scene)
        self.gauge.fill(slots.parameters(scene, list(scene.gains.values())))

    def step(self, q: Array, target: Any, dt: float) -> Step:
        """One step of the arm."""
        return self.ik.step(q, target, dt=dt)


def measured(bodies: str) -> tuple[str, str]:
    """What is measured for the figures of the joints, and of the links."""
    return "joints", "shapes" if bodies == "shapes" else "links"


def _common(problem: Problem, slots: Slots) -> dict[str, Any]:
    """Arguments of criteria that keep away from obstacles."""
    return {"obstacles": placeholders(slots), "capacity": dict(slots.counts), "bodies": problem.bodies}


def _measure(problem: Problem, common: Mapping[str, Any], bodies: str) -> Any:
    return problem.criteria.registered(AVOIDANCE, {**common, "bodies": bodies})


def _strategy(problem: Problem, structure: Structure) -> Strategy:
    if structure.strategy == GIVEN and problem.strategy is not None:
        return problem.strategy
    return catalogue.strategy(structure.strategy, structure.options)


def _limits(limits: Limits, on: bool) -> Limits:
    return replace(limits, position=on)


class Workshop:
    """Builds solvers one after the other in an executor, and keeps the latest ones.

    Args:
        problem: what stays as it is.
        executor: where they are built.
    """

    def __init__(self, problem: Problem, executor: Executor) -> None:
        self._problem, self._executor = problem, executor
        self._kept: OrderedDict[str, Solver] = OrderedDict()
        self._running: Future[Solver] | None = None
        self._next: Structure | None = None

    @property
    def busy(self) -> bool:
        """Whether a solver is being built."""
        return self._running is not None

    def request(self, structure: Structure) -> None:
        """Ask for a solver; of several requests only the latest is met."""
        self._next = structure
        self._start()

    def keep(self, solver: Solver) -> None:
        """Keep a solver for later."""
        self._kept[solver.structure.key] = solver
        self._kept.move_to_end(solver.structure.key)
        while len(self._kept) > KEPT:
            self._kept.popitem(last=False)

    def poll(self) -> Solver | BaseException | None:
        """The solver that was asked for last, or why there is none; None where nothing is ready."""
        if self._running is not None and self._running.done():
            future, self._running = self._running, None
            error = future.exception()
            if error is None:
                self.keep(future.result())
            if self._next is None:
                return future.result() if error is None else error
        self._start()
        if self._running is None and self._next is not None:
            structure, self._next = self._next, None
            return self._kept[structure.key]
        return None

    def _start(self) -> None:
        """Start to build what was asked for last, unless something is being built or it is there already."""
        if self._running is None and self._next is not None and self._next.key not in self._kept:
            structure, self._next = self._next, None
            self._running = self._executor.submit(Solver, self._problem, structure)
