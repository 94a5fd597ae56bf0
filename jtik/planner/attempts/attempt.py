"""An attempt: what was recorded while an operator guided the end effector."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from jtik.arguments import array_of, finite_array, names, number, positive_number, several, text
from jtik.errors import ArgumentError
from jtik.planner.files.plain import entries, inside, label, plain, plain_mapping
from jtik.types import Array

MOST_SAMPLES = 2_000_000
"""Largest number of samples of an attempt, nine hours of 60 a second."""

MOST_CHANGES = 1_000_000
"""Largest number of changes of the scene in an attempt."""

SceneChange = tuple[float, Mapping[str, Any]]
"""When the obstacles changed [s], and what they were from then on: a dict of `jtik.Scene.to_dict`."""

REQUIRED = ("name", "dt", "times", "configurations", "targets", "scenes", "strategy", "criteria")
OPTIONAL = ("settings", "parent", "branched_at")


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class Attempt:
    """A recorded path of targets and the motion that followed it.

    An attempt is complete by itself: that of a branch has the samples of its parent up to the branch, too. The robot is
    not part of it. Arrays are read-only copies.

    Attributes:
        name: its name, unique in a `History`.
        dt: time of one step of the solver that recorded it [s].
        times: time of each sample (k,) [s]; the first is 0, and they increase.
        configurations: the configuration at each time (k, nq) [rad] and [m].
        targets: the target at each time: its position (k, 2) or (k, 3) [m], or position and unit quaternion (w, x, y,
            z), (k, 7).
        scenes: when the obstacles changed, and what they were from then on; the first at time 0. Empty without a scene.
        strategy: name of the strategy.
        criteria: names of the criteria.
        settings: everything else that the solver was set to, as plain data: options, gains, limits.
        parent: name of the attempt that it branched from, or that it solves again; None for none.
        branched_at: time at which it left its parent [s]; None for an attempt that shares no sample with it.

    Raises:
        ArgumentError: for a value that cannot be used, naming it.
    """

    name: str
    dt: float
    times: Array
    configurations: Array
    targets: Array
    scenes: tuple[SceneChange, ...] = ()
    strategy: str = ""
    criteria: tuple[str, ...] = ()
    settings: Mapping[str, Any] = field(default_factory=dict)
    parent: str | None = None
    branched_at: float | None = None

    def __post_init__(self) -> None:
        self._set(**_checked(self, ""))

    def _set(self, **values: Any) -> None:
        for key, value in values.items():
            object.__setattr__(self, key, value)

    def __len__(self) -> int:
        return len(self.times)

    def __repr__(self) -> str:
        origin = "" if self.parent is None else f", from {self.parent!r}"
        return f"Attempt({self.name!r}, {len(self)} samples, {self.duration:.3g} s{origin})"

    @property
    def duration(self) -> float:
        """Time of the last sample [s]."""
        return float(self.times[-1])

    def index(self, time: float) -> int:
        """The last sample at or before a time [s]; the first for an earlier time."""
        return max(int(np.searchsorted(self.times, number("time", time), side="right")) - 1, 0)

    def scene_at(self, time: float) -> dict[str, Any] | None:
        """The obstacles at a time [s], as a dict of `jtik.Scene.to_dict`; None without a scene."""
        earlier = [scene for begin, scene in self.scenes if begin <= time]
        found: dict[str, Any] | None = plain("scene", earlier[-1]) if earlier else None
        return found

    def cut(self, time: float) -> Self:
        """The attempt up to a time [s], at least its first sample."""
        end = self.index(time) + 1
        return replace(
            self,
            times=self.times[:end],
            configurations=self.configurations[:end],
            targets=self.targets[:end],
            scenes=tuple(change for change in self.scenes if change[0] <= self.times[end - 1]),
        )

    def to_json(self) -> dict[str, Any]:
        """Plain data of which `from_json` makes the same attempt, to the last bit."""
        return {
            "name": self.name,
            "dt": self.dt,
            "times": self.times.tolist(),
            "configurations": self.configurations.tolist(),
            "targets": self.targets.tolist(),
            "scenes": [[time, plain("scene", scene)] for time, scene in self.scenes],
            "strategy": self.strategy,
            "criteria": list(self.criteria),
            "settings": plain("settings", self.settings),
            "parent": self.parent,
            "branched_at": self.branched_at,
        }

    @classmethod
    def from_json(cls, data: object, where: str = "attempt") -> Self:
        """The attempt of `to_json`.

        Args:
            data: plain data.
            where: where the data is, such as a file and a key, for messages.

        Raises:
            ArgumentError: for anything else, naming the place and the key.
        """
        found = entries(where, data, REQUIRED, OPTIONAL)
        made = object.__new__(cls)
        made._set(settings={}, parent=None, branched_at=None)
        made._set(**found)
        made._set(**_checked(made, where))
        return made


def _checked(given: Attempt, where: str) -> dict[str, Any]:
    """The values in the form that the class keeps. Raises ArgumentError for others."""
    times = _rows(inside(where, "times"), given.times, [(None,)], "at least one finite time [s]")
    if times[0] != 0 or (np.diff(times) <= 0).any():
        raise ArgumentError(inside(where, "times"), _disorder(times), "times that begin with 0 and increase [s]")
    k = len(times)
    q = finite_array(
        inside(where, "configurations"), given.configurations, (k, None), f"one configuration for each of {k}"
    )
    accepted = f"({k}, 2) or ({k}, 3) for positions, ({k}, 7) for poses"
    targets = array_of(inside(where, "targets"), given.targets, [(k, 2), (k, 3), (k, 7)], accepted)
    parent = None if given.parent is None else label(inside(where, "parent"), given.parent)
    branched_at = given.branched_at
    if branched_at is not None:
        branched_at = number(inside(where, "branched_at"), branched_at, "None, or a time from 0 [s]", minimum=0.0)
        if parent is None:
            raise ArgumentError(inside(where, "branched_at"), branched_at, "None for an attempt without a parent")
    return {
        "name": label(inside(where, "name"), given.name),
        "dt": positive_number(inside(where, "dt"), given.dt),
        "times": _frozen(times),
        "configurations": _frozen(q),
        "targets": _frozen(targets),
        "scenes": _scenes(inside(where, "scenes"), given.scenes),
        "strategy": text(inside(where, "strategy"), given.strategy),
        "criteria": names(inside(where, "criteria"), given.criteria, "names of criteria"),
        "settings": plain_mapping(inside(where, "settings"), given.settings),
        "parent": parent,
        "branched_at": branched_at,
    }


def _rows(argument: str, value: ArrayLike, shapes: Any, accepted: str) -> Array:
    array = array_of(argument, value, shapes, accepted)
    if len(array) > MOST_SAMPLES:
        raise ArgumentError(argument, f"{len(array)} samples", f"at most {MOST_SAMPLES}")
    return array


def _disorder(times: Array) -> str:
    if times[0] != 0:
        return f"{times[0]:g} at index 0"
    i = int(np.argmax(np.diff(times) <= 0))
    return f"{times[i]:g} before {times[i + 1]:g} at index {i}"


def _scenes(argument: str, value: Iterable[Any]) -> tuple[SceneChange, ...]:
    accepted = "pairs of a time [s] and a scene, the first at time 0, in the order of time"
    changes = several(argument, value, accepted)
    if len(changes) > MOST_CHANGES:
        raise ArgumentError(argument, f"{len(changes)} changes", f"at most {MOST_CHANGES}")
    found: list[SceneChange] = []
    for i, change in enumerate(changes):
        pair = several(f"{argument}[{i}]", change, accepted)
        if len(pair) != 2:
            raise ArgumentError(f"{argument}[{i}]", f"{len(pair)} values", accepted)
        time = number(f"{argument}[{i}][0]", pair[0], accepted, minimum=found[-1][0] if found else 0.0)
        if not found and time != 0:
            raise ArgumentError(f"{argument}[0][0]", time, accepted)
        found.append((time, plain_mapping(f"{argument}[{i}][1]", pair[1])))
    return tuple(found)


def _frozen(array: Array) -> Array:
    array.flags.writeable = False
    return array
