"""The file of a plan: scene, settings and attempts as one JSON document.

The document is an object with these keys:

- ``format``: "jtik plan"; ``version``: 1.
- ``robot``: the robot that the plan is of: ``name``, ``joint_names`` and ``nq``, the length of a configuration.
- ``scene``: the obstacles, as `jtik.Scene.to_dict` gives them.
- ``settings``: strategy, criteria, gains and whatever else the planner was set to, as plain data.
- ``attempts``: a list of objects with the attributes of `jtik.planner.attempts.attempt.Attempt` as keys; arrays are
  lists of rows, times in seconds, angles in radians, lengths in metres.
- ``chosen``: name of the chosen attempt, or null.
- ``journal``: in a snapshot only, its number in the journal (`jtik.planner.files.journal`).
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NoReturn, Self

from jtik.arguments import existing_file, instance, integer, names, several
from jtik.arguments import path as read_path
from jtik.errors import ArgumentError
from jtik.geometry import Scene
from jtik.planner.attempts.attempt import Attempt
from jtik.planner.attempts.history import History
from jtik.planner.files.plain import entries, inside, label, plain_mapping
from jtik.robot import Robot
from jtik.types import Array

FORMAT = "jtik plan"
VERSION = 1

LARGEST = 2**29
"""Largest file that is read [bytes]."""

ROWS = 50
"""Rows of an array that are written at once: other threads run between."""

ACCEPTED = "a file of a plan that jtik wrote"


@dataclass(frozen=True, eq=False, kw_only=True)
class Plan:
    """Everything that an operator has done with a robot.

    Attributes:
        robot: the robot's ``name``, ``joint_names`` and ``nq``, of `Plan.robot_of`.
        scene: the obstacles, a dict of `jtik.Scene.to_dict`.
        settings: what the planner was set to, as plain data.
        history: the attempts.

    Raises:
        ArgumentError: for a value that cannot be used, naming it.
    """

    robot: Mapping[str, Any]
    scene: Mapping[str, Any] = field(default_factory=dict)
    settings: Mapping[str, Any] = field(default_factory=dict)
    history: History = field(default_factory=History)

    def __post_init__(self) -> None:
        object.__setattr__(self, "robot", _robot("robot", self.robot))
        object.__setattr__(self, "scene", plain_mapping("scene", self.scene))
        object.__setattr__(self, "settings", plain_mapping("settings", self.settings))
        instance("history", self.history, History, "a History")
        _check_width("history", self.history, self.robot["nq"])

    @staticmethod
    def robot_of(robot: Robot) -> dict[str, Any]:
        """What a plan keeps of a robot."""
        return {"name": robot.name, "joint_names": list(robot.joint_names), "nq": robot.nq}

    def save(self, path: str | Path) -> None:
        """Write the file: a reader finds either the old one or the new one, whenever the process or the machine stops.

        Raises:
            OSError: when it cannot be written; nothing of it then stays behind.
        """
        write_atomically(read_path("path", path), self.pieces())

    def pieces(self, texts: Callable[[Attempt], Iterator[str]] | None = None, **more: Any) -> Iterator[str]:
        """The document in pieces of ASCII text, none of which takes long to make.

        Args:
            texts: gives the pieces of an attempt; `attempt_pieces` by default.
            more: further keys and values.
        """
        of_attempt = attempt_pieces if texts is None else texts
        head = {"format": FORMAT, "version": VERSION, "robot": self.robot, **more}
        yield _text(head)[:-1] + f', "scene": {_text(self.scene)}, "settings": {_text(self.settings)}'
        yield f', "chosen": {_text(self.history.chosen)}, "attempts": ['
        for i, attempt in enumerate(self.history):
            yield ",\n" if i else "\n"
            yield from of_attempt(attempt)
        yield "]}\n"

    @classmethod
    def load(cls, path: str | Path, robot: Robot | None = None) -> Self:
        """Read a file that `save` wrote.

        Args:
            path: the file.
            robot: the robot that the plan is to be of; None for any.

        Raises:
            ArgumentError: for anything that is not a plan, naming the file and the key, or a plan of another robot.
            OSError: when it cannot be read.
        """
        found, _ = read(existing_file("path", path))
        plan = cls(**{key: getattr(found, key) for key in ("robot", "scene", "settings", "history")})
        if robot is not None and plan.robot["joint_names"] != list(robot.joint_names):
            given = f"{path}, a plan of {plan.robot['name']!r} with the joints {', '.join(plan.robot['joint_names'])}"
            raise ArgumentError("path", given, f"a plan of {robot.name!r}: {', '.join(robot.joint_names)}")
        return plan


def read(path: Path) -> tuple[Plan, int]:
    """The plan of a file, and its number as a snapshot, 0 of another. Raises ArgumentError for another file."""
    where = path.name
    keys = ("format", "version", "robot", "scene", "settings", "attempts", "chosen")
    document = read_json(path)
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        raise ArgumentError("path", f"{path}, which holds no plan", ACCEPTED)
    if document.get("version") != VERSION:
        raise ArgumentError("path", f"{path} of version {document.get('version')!r}", f"version {VERSION}")
    found = entries(where, document, keys, ("journal",))
    history = History.from_json({key: found[key] for key in ("attempts", "chosen")}, where)
    robot = _robot(inside(where, "robot"), found["robot"])
    _check_width(inside(where, "attempts"), history, robot["nq"])
    known: set[str] = set()
    for i, attempt in enumerate(history):
        for j, (_, each) in enumerate(attempt.scenes):
            _check_scene(inside(where, f"attempts[{i}].scenes[{j}][1]"), _news(each, known))
    scene = plain_mapping(inside(where, "scene"), found["scene"])
    _check_scene(inside(where, "scene"), scene)
    settings = plain_mapping(inside(where, "settings"), found["settings"])
    number = integer(inside(where, "journal"), found.get("journal", 0))
    return Plan(robot=robot, scene=scene, settings=settings, history=history), number


def read_json(path: Path) -> Any:
    """The JSON document of a file. Raises ArgumentError for one that is no JSON, or larger than `LARGEST`."""
    if not path.is_file():
        raise ArgumentError("path", f"{path}, which is no regular file", ACCEPTED)
    if path.stat().st_size > LARGEST:
        raise ArgumentError("path", f"{path} of {path.stat().st_size} bytes", f"at most {LARGEST} bytes")
    try:
        return parsed(path.read_bytes())
    except (ValueError, RecursionError) as error:
        given = f"{path}, which is no JSON document ({str(error)[:200] or type(error).__name__})"
        raise ArgumentError("path", given, ACCEPTED) from error


def parsed(data: bytes) -> Any:
    """JSON, without the numbers NaN and Infinity. Raises ValueError or RecursionError for anything else."""
    return json.loads(data.decode("utf-8"), parse_constant=_refuse)


def write_atomically(path: Path, pieces: Iterable[str]) -> None:
    """Write a file beside its place, onto the disk, and rename it. Raises OSError; nothing then stays behind."""
    temporary = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        with temporary.open("w", encoding="utf-8", newline="\n") as file:
            file.writelines(pieces)
            file.flush()
            os.fsync(file.fileno())
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
    _sync_folder(path.parent)


def _sync_folder(folder: Path) -> None:
    """Put the names of a folder onto the disk, where the system can."""
    if not hasattr(os, "O_DIRECTORY"):
        return
    handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _robot(argument: str, value: object) -> dict[str, Any]:
    found = entries(argument, value, ("name", "joint_names", "nq"))
    several(f"{argument}.joint_names", found["joint_names"], "names of joints")
    return {
        "name": label(f"{argument}.name", found["name"]),
        "joint_names": list(names(f"{argument}.joint_names", found["joint_names"], "names of joints")),
        "nq": integer(f"{argument}.nq", found["nq"]),
    }


def _news(scene: Mapping[str, Any], known: set[str]) -> Mapping[str, Any]:
    """The scene without the obstacles that were checked before: most change while the others stay."""
    rows = scene.get("obstacles")
    if set(scene) != {"obstacles"} or not isinstance(rows, Mapping):
        return scene
    texts = {name: _text(row) for name, row in rows.items()}
    new = {name: row for name, row in rows.items() if texts[name] not in known}
    known.update(texts.values())
    return {"obstacles": new} if new else {}


def _check_scene(argument: str, scene: Mapping[str, Any]) -> None:
    """Raise ArgumentError unless it is a scene, or empty."""
    if not scene:
        return
    try:
        Scene.from_dict(scene)
    except ArgumentError as error:
        raise ArgumentError(f"{argument}.{error.argument}", error.given, error.accepted) from error


def _check_width(argument: str, history: History, nq: int) -> None:
    for attempt in history:
        if attempt.configurations.shape[1] != nq:
            given = f"{attempt.name!r} with configurations of {attempt.configurations.shape[1]} numbers"
            raise ArgumentError(argument, given, f"{nq} numbers: those of the robot of the plan")


def attempt_pieces(attempt: Attempt) -> Iterator[str]:
    """The text of ``attempt.to_json()``."""
    arrays = ("times", "configurations", "targets")
    rest = attempt.cut(0.0).to_json()
    rest["scenes"] = []
    for name in arrays:
        del rest[name]
    del rest["scenes"]
    yield _text(rest)[:-1]
    yield ', "scenes": ['
    for i, change in enumerate(attempt.scenes):
        yield ", " * bool(i) + _text(list(change))
    yield "]"
    for name in arrays:
        yield f', "{name}": ['
        yield from _rows(getattr(attempt, name))
        yield "]"
    yield "}"


def _rows(array: Array) -> Iterator[str]:
    for start in range(0, len(array), ROWS):
        yield ", " * bool(start) + _text(array[start : start + ROWS].tolist())[1:-1]


def _text(value: Any) -> str:
    return json.dumps(value, allow_nan=False)


def _refuse(text: str) -> NoReturn:
    raise ValueError(f"{text} is no number of JSON")
