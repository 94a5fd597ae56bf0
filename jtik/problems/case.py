"""One problem, and an ordered set of them: what a study solves, as plain data that can be saved with its result."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike

from jtik._loop.options import positive
from jtik.errors import ArgumentError, UnknownNameError, finite_array
from jtik.problems.plain import frozen_array, frozen_target, plain_target
from jtik.robot import Robot
from jtik.task import Task
from jtik.task.reduction import reduced
from jtik.types import Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Case:
    """One problem: from a start to one target, or along a path of targets.

    Everything is copied in; arrays are read-only. Cases are equal when all they hold is equal.

    Attributes:
        name: unique in its set, such as "reachable-007".
        kind: what sort of problem it is: "reachable", "near_singular", "boundary", "unreachable", "near_limits",
            "circle", "line", "lissajous", "path", "scene", or a word of your own.
        q0: where to start, (nq,) [rad] and [m], of the robot that `InverseKinematics.robot` is: without locked joints.
        targets: what the task reads as a target: one, or those of a path in order.
        dt: time from one target of a path to the next [s].
        closed: whether the path ends where it began, so that what the joints drift can be measured.
        parameters: values of live parameters of criteria, by name, such as "obstacle_avoidance.centers".
        reachable: whether the targets can be reached with the joint limits kept; None where nobody knows.
        known: answers that are known, by name: "error" (least norm of the task error [m], or [rad] of an orientation),
            "H" (least value of the criterion on the target), or what the origin of the case speaks of.
        origin: where it comes from: how it was drawn, or a paper.

    Raises:
        ArgumentError: for numbers that are not finite, no target, a negative dt, or a closed path of one target.
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
            if not isinstance(getattr(self, argument), str) or not getattr(self, argument):
                raise ArgumentError(argument, getattr(self, argument), "a word or two")
        q0 = finite_array("q0", self.q0, (None,))
        q0.flags.writeable = False
        if isinstance(self.targets, (str, Mapping)) or not isinstance(self.targets, Iterable):
            raise ArgumentError("targets", self.targets, "a sequence of targets, even of one: targets=[target]")
        targets = tuple(frozen_target(f"targets[{i}]", target) for i, target in enumerate(self.targets))
        if not targets:
            raise ArgumentError("targets", "none", "one target, or those of a path")
        if self.closed and len(targets) < 3:
            raise ArgumentError("closed", True, f"False for {len(targets)} targets: a closed path has three or more")
        own = {
            "q0": q0,
            "targets": targets,
            "dt": None if self.dt is None else positive("dt", self.dt),
            "closed": bool(self.closed),
            "parameters": {
                str(key): frozen_array(f"parameters[{key!r}]", value) for key, value in self.parameters.items()
            },
            "reachable": None if self.reachable is None else bool(self.reachable),
            "known": {str(key): float(finite_array(f"known[{key!r}]", x, ())) for key, x in self.known.items()},
        }
        for attribute, value in own.items():
            object.__setattr__(self, attribute, value)

    @property
    def target(self) -> Any:
        """The first target, which is the only one unless this is a path."""
        return self.targets[0]

    @property
    def is_path(self) -> bool:
        """Whether there are several targets to follow."""
        return len(self.targets) > 1

    def __eq__(self, other: object) -> bool:
        return self.as_data() == other.as_data() if isinstance(other, Case) else NotImplemented

    def __hash__(self) -> int:
        return hash((self.name, self.kind, self.q0.tobytes()))

    def __repr__(self) -> str:
        what = f"{len(self.targets)} targets" if self.is_path else f"target {plain_target(self.target)}"
        return f"Case({self.name!r}, {self.kind!r}, {what})"

    def as_data(self) -> dict[str, Any]:
        """All of it as strings, numbers, lists and dicts; JSON keeps every bit."""
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
        """The case that `as_data` wrote. Raises ArgumentError for anything else."""
        return cls(**_entries("case", data, set(cls.__dataclass_fields__), {"name", "kind", "q0", "targets"}))


@dataclass(frozen=True)
class ProblemSet(Sequence[Case]):
    """Cases in order, each with a name of its own.

    ``problems[3]`` and ``problems["reachable-003"]`` are cases, ``problems[:10]`` is a set again, and so is the sum of
    two sets.

    Attributes:
        name: what to call it.
        cases: the cases.
        seed: what the random numbers were drawn from, where there were any.
        origin: how the cases came about.

    Raises:
        ArgumentError: when two cases have the same name, or something is not a case.
    """

    name: str
    cases: tuple[Case, ...]
    seed: int | None = None
    origin: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "cases", tuple(self.cases))
        seen: set[str] = set()
        for i, case in enumerate(self.cases):
            if not isinstance(case, Case):
                raise ArgumentError(f"cases[{i}]", case, "a jtik.problems.Case")
            if case.name in seen:
                raise ArgumentError(f"cases[{i}].name", case.name, "a name no other case has; see ProblemSet.renamed")
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
        """The kinds of its cases, in the order they first appear."""
        return tuple(dict.fromkeys(case.kind for case in self.cases))

    def of(self, *kinds: str) -> ProblemSet:
        """Its cases of those kinds. Raises UnknownNameError for a kind it has none of."""
        for kind in kinds:
            if kind not in self.kinds:
                raise UnknownNameError("kind of case", kind, self.kinds)
        return replace(self, cases=tuple(case for case in self.cases if case.kind in kinds))

    def renamed(self, name: str) -> ProblemSet:
        """The same cases as ``name``-000, ``name``-001 ...: sets of one kind and several seeds can then be added."""
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
        """See that every case fits.

        Args:
            robot, task, joints, at: as `InverseKinematics` takes them; a robot that is reduced already will do.
            parameters: live parameters of the criteria, such as ``ik.parameters``, for cases that set any; None does
                not look at them.

        Raises:
            ArgumentError: naming the first case that does not fit, and in what: ``problems['circle-000'].q0``.
        """
        robot, tasks = reduced(robot, task, joints, at)
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
        """All of it as strings, numbers, lists and dicts; JSON keeps every bit."""
        cases = [case.as_data() for case in self.cases]
        return {"name": self.name, "seed": self.seed, "origin": self.origin, "cases": cases}

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> ProblemSet:
        """The set that `as_data` wrote. Raises ArgumentError for anything else."""
        entries = _entries("problems", data, {"name", "seed", "origin", "cases"}, {"name", "cases"})
        return cls(**{**entries, "cases": tuple(Case.from_data(case) for case in entries["cases"])})


def case_name(name: str, index: int) -> str:
    """The name of the case with that index in a set: "reachable-007"."""
    return f"{name}-{index:03d}"


def _joined(glue: str, *texts: str) -> str:
    """The texts that say something, each once."""
    return glue.join(dict.fromkeys(text for text in texts if text))


def _place(case: Case, inner: str) -> str:
    return f"problems[{case.name!r}].{inner}"


def _checked(case: Case, inner: str, check: Callable[[], object]) -> None:
    """Run a check of one part of a case, and say in its error where that part is."""
    try:
        check()
    except ArgumentError as error:
        # of a dict of targets the error says which
        deeper = error.argument.removeprefix("target") if error.argument.startswith("target[") else ""
        raise ArgumentError(_place(case, inner + deeper), error.given, error.accepted) from None


def _entries(argument: str, data: Mapping[str, Any], known: set[str], needed: set[str]) -> dict[str, Any]:
    """The entries of a mapping, all of them known and none of the needed ones missing."""
    if not isinstance(data, Mapping) or not needed <= data.keys() <= known:
        given = sorted(data) if isinstance(data, Mapping) else type(data).__name__
        raise ArgumentError(argument, given, f"a mapping with {sorted(needed)}, and maybe {sorted(known - needed)}")
    return dict(data)


__all__ = ["Case", "ProblemSet", "case_name"]
