"""One problem (`Case`) and an ordered set of problems (`ProblemSet`), as plain data that can be saved."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike

from jtik.arguments import finite_array, flag, instance, integer, mapping, number, positive_number, several, text
from jtik.arguments import name as read_name
from jtik.constructors import Constructed
from jtik.errors import ArgumentError, UnknownNameError
from jtik.problems.plain_values import frozen_array, frozen_target, plain_target
from jtik.robot import Robot
from jtik.task import Task
from jtik.task.reduction import reduced
from jtik.types import Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Case(metaclass=Constructed):
    """One inverse kinematics problem: a start and one target, or a start and a path of targets.

    All values are copied. Arrays are read-only. Two cases are equal if all their values are equal.

    Attributes:
        name: unique name in the set, such as "reachable-007".
        kind: kind of problem: "reachable", "near_singular", "boundary", "unreachable", "near_limits", "circle", "line",
            "lissajous", "path", "scene", or a name of your own.
        q0: start configuration of the reduced robot (`InverseKinematics.robot`), (nq,) [rad] and [m].
        targets: one target, or the targets of a path in order, in any form that the task accepts.
        dt: time between consecutive targets of a path [s].
        closed: whether the path ends at its first target, so that joint drift can be measured.
        parameters: values of live parameters of criteria by name, such as "obstacle_avoidance.centers".
        reachable: whether the targets can be reached within the joint limits; None if unknown.
        known: known results by name: "error" (smallest norm of the task error [m], or [rad] for an orientation),
            "H" (smallest value of the criterion on the target), or names that ``origin`` explains.
        origin: how the case was drawn, or the paper it comes from.

    Raises:
        ArgumentError: for non-finite numbers, no target, a non-positive dt, or a closed path of fewer than three
            targets.
    """

    name: str
    kind: str
    q0: Array
    targets: tuple[Any, ...]
    dt: float | None = None
    closed: bool = False
    parameters: Mapping[str, Array] = field(default_factory=dict)
    reachable: bool | None = None
    known: Mapping[str, float] = field(default_factory=dict)
    origin: str = ""

    def __post_init__(self) -> None:
        for argument in ("name", "kind"):
            read_name(argument, getattr(self, argument), "a non-empty string")
        text("origin", self.origin)
        q0 = finite_array("q0", self.q0, (None,))
        q0.flags.writeable = False
        given = several("targets", self.targets, "a sequence of targets; for a single target: targets=[target]")
        targets = tuple(frozen_target(f"targets[{i}]", target) for i, target in enumerate(given))
        if not targets:
            raise ArgumentError("targets", "none", "at least one target")
        closed = flag("closed", self.closed, "whether the path ends at its first target")
        if closed and len(targets) < 3:
            raise ArgumentError("closed", True, f"False for {len(targets)} targets: a closed path needs at least three")
        own = {
            "q0": q0,
            "targets": targets,
            "dt": None if self.dt is None else positive_number("dt", self.dt),
            "closed": closed,
            "parameters": {
                str(key): frozen_array(f"parameters[{key!r}]", value)
                for key, value in mapping("parameters", self.parameters, "a dict from name to values").items()
            },
            "reachable": None if self.reachable is None else flag("reachable", self.reachable, "or None if unknown"),
            "known": {
                str(key): number(f"known[{key!r}]", x)
                for key, x in mapping("known", self.known, "a dict from name to number").items()
            },
        }
        for attribute, value in own.items():
            object.__setattr__(self, attribute, value)

    @property
    def target(self) -> Any:
        """The first target."""
        return self.targets[0]

    @property
    def is_path(self) -> bool:
        """Whether there is more than one target."""
        return len(self.targets) > 1

    def __eq__(self, other: object) -> bool:
        return self.as_data() == other.as_data() if isinstance(other, Case) else NotImplemented

    def __hash__(self) -> int:
        return hash((self.name, self.kind, self.q0.tobytes()))

    def __repr__(self) -> str:
        what = f"{len(self.targets)} targets" if self.is_path else f"target {plain_target(self.target)}"
        return f"Case({self.name!r}, {self.kind!r}, {what})"

    def as_data(self) -> dict[str, Any]:
        """All values as strings, numbers, lists and dicts, which JSON stores without loss."""
        return {
            "name": self.name,
            "kind": self.kind,
            "q0": self.q0.tolist(),
            "targets": [plain_target(target) for target in self.targets],
            "dt": self.dt,
            "closed": self.closed,
            "parameters": {name: value.tolist() for name, value in self.parameters.items()},
            "reachable": self.reachable,
            "known": dict(self.known),
            "origin": self.origin,
        }

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> Case:
        """The case that `as_data` described.

        Args:
            data: plain dicts, lists, numbers and texts.

        Raises:
            ArgumentError: for other data.
        """
        return cls(**_entries("case", data, set(cls.__dataclass_fields__), {"name", "kind", "q0", "targets"}))


@dataclass(frozen=True)
class ProblemSet(Sequence[Case], metaclass=Constructed):
    """An ordered set of cases with unique names.

    ``problems[3]`` and ``problems["reachable-003"]`` are cases. ``problems[:10]`` and the sum of two sets are sets.

    Attributes:
        name: name of the set.
        cases: the cases.
        seed: seed of the random numbers; None if none were used.
        origin: how the cases were generated.

    Raises:
        ArgumentError: if two cases have the same name, or an element is not a case.
    """

    name: str
    cases: tuple[Case, ...]
    seed: int | None = None
    origin: str = ""

    def __post_init__(self) -> None:
        read_name("name", self.name)
        text("origin", self.origin)
        if self.seed is not None:
            object.__setattr__(self, "seed", integer("seed", self.seed))
        object.__setattr__(self, "cases", several("cases", self.cases, "a list of jtik.problems.Case"))
        seen: set[str] = set()
        for i, case in enumerate(self.cases):
            if not isinstance(case, Case):
                raise ArgumentError(f"cases[{i}]", case, "a jtik.problems.Case")
            if case.name in seen:
                raise ArgumentError(f"cases[{i}].name", case.name, "a unique name; see ProblemSet.renamed")
            seen.add(case.name)

    def __len__(self) -> int:
        return len(self.cases)

    @overload
    def __getitem__(self, index: int | str) -> Case: ...
    @overload
    def __getitem__(self, index: slice) -> ProblemSet: ...
    def __getitem__(self, index: int | str | slice) -> Case | ProblemSet:
        if isinstance(index, slice):
            return replace(self, cases=self.cases[index])
        if isinstance(index, str):
            named = {case.name: case for case in self.cases}
            if index not in named:
                raise UnknownNameError("case", index, named)
            return named[index]
        return self.cases[index]

    def __add__(self, other: ProblemSet) -> ProblemSet:
        if not isinstance(other, ProblemSet):
            return NotImplemented
        return ProblemSet(
            name=_joined(" + ", self.name, other.name),
            cases=self.cases + other.cases,
            seed=self.seed if self.seed == other.seed else None,
            origin=_joined("; ", self.origin, other.origin),
        )

    def __repr__(self) -> str:
        kinds = ", ".join(f"{sum(case.kind == kind for case in self)} {kind}" for kind in self.kinds)
        return f"ProblemSet({self.name!r}, {len(self)} cases: {kinds or 'none'})"

    @property
    def kinds(self) -> tuple[str, ...]:
        """The kinds of its cases, in order of first appearance."""
        return tuple(dict.fromkeys(case.kind for case in self.cases))

    def of(self, *kinds: str) -> ProblemSet:
        """The cases of some kinds.

        Args:
            kinds: the kinds, such as "reachable".

        Raises:
            UnknownNameError: when no case is of a kind.
        """
        for kind in kinds:
            if kind not in self.kinds:
                raise UnknownNameError("kind of case", kind, self.kinds)
        return replace(self, cases=tuple(case for case in self.cases if case.kind in kinds))

    def renamed(self, name: str) -> ProblemSet:
        """The same cases with the names ``name``-000, ``name``-001 ...

        Sets of one kind and several seeds can then be added.

        Args:
            name: first part of all names.
        """
        cases = tuple(replace(case, name=case_name(name, i)) for i, case in enumerate(self.cases))
        return replace(self, name=name, cases=cases)

    def check(
        self,
        robot: Robot,
        task: Task | Iterable[Task],
        *,
        joints: str | Iterable[str] | None = None,
        at: ArrayLike | None = None,
        parameters: Mapping[str, ArrayLike] | None = None,
    ) -> None:
        """Check that every case fits a robot, its tasks and its live parameters.

        Args:
            robot: the robot, or its reduced robot.
            task: a Task, or several.
            joints: joints that move, as in `InverseKinematics`.
            at: configuration at which the other joints are locked, as in `InverseKinematics`.
            parameters: live parameters of the criteria, such as ``ik.parameters``; None skips their check.

        Raises:
            ArgumentError: naming the first value that does not fit, such as ``problems['circle-000'].q0``.
        """
        robot, tasks = reduced(instance("robot", robot, Robot, "a jtik.Robot"), task, joints, at)
        for case in self.cases:
            _checked(case, "q0", lambda case=case: robot.configuration(case.q0))  # type: ignore[misc]
            for i, target in enumerate(case.targets):
                _checked(case, f"targets[{i}]", lambda target=target: tasks.read_target(target))  # type: ignore[misc]
            for name, value in case.parameters.items() if parameters is not None else ():
                live = {key: np.shape(each) for key, each in parameters.items()}  # type: ignore[union-attr]
                if live.get(name) != value.shape:
                    accepted = f"one of {live}" if name not in live else f"shape {live[name]}"
                    raise ArgumentError(_place(case, f"parameters[{name!r}]"), f"shape {value.shape}", accepted)

    def as_data(self) -> dict[str, Any]:
        """All values as strings, numbers, lists and dicts, which JSON stores without loss."""
        cases = [case.as_data() for case in self.cases]
        return {"name": self.name, "seed": self.seed, "origin": self.origin, "cases": cases}

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> ProblemSet:
        """The set that `as_data` described.

        Args:
            data: plain dicts, lists, numbers and texts.

        Raises:
            ArgumentError: for other data.
        """
        entries = _entries("problems", data, {"name", "seed", "origin", "cases"}, {"name", "cases"})
        return cls(**{**entries, "cases": tuple(Case.from_data(case) for case in entries["cases"])})


def case_name(name: str, index: int) -> str:
    """The name of the case at an index of a set, such as "reachable-007"."""
    return f"{name}-{index:03d}"


def _joined(glue: str, *texts: str) -> str:
    """The non-empty texts without duplicates, joined."""
    return glue.join(dict.fromkeys(text for text in texts if text))


def _place(case: Case, inner: str) -> str:
    return f"problems[{case.name!r}].{inner}"


def _checked(case: Case, inner: str, check: Callable[[], object]) -> None:
    """Run a check of one value of a case; its error names the case and the value."""
    try:
        check()
    except ArgumentError as error:
        # for a dict of targets, the error names the task
        deeper = error.argument.removeprefix("target") if error.argument.startswith("target[") else ""
        raise ArgumentError(_place(case, inner + deeper), error.given, error.accepted) from None


def _entries(argument: str, data: Mapping[str, Any], known: set[str], needed: set[str]) -> dict[str, Any]:
    """The entries of a mapping, after a check that all are known and none is missing."""
    if not isinstance(data, Mapping) or not needed <= data.keys() <= known:
        given = sorted(data) if isinstance(data, Mapping) else type(data).__name__
        raise ArgumentError(
            argument, given, f"a mapping with {sorted(needed)}, and optionally {sorted(known - needed)}"
        )
    return dict(data)


__all__ = ["Case", "ProblemSet", "case_name"]
