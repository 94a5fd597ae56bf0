"""Joint commands: positions, velocities and accelerations at times, and the files that controllers read."""

from __future__ import annotations

import csv
import io
import json
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from jtik.arguments import choice, existing_file, instance
from jtik.arguments import path as read_path
from jtik.errors import ArgumentError
from jtik.planner.commit import ros2
from jtik.planner.files.plan_file import parsed, write_atomically
from jtik.result.archive import read_archive, write_archive
from jtik.types import Array

FORMAT = "jtik joint commands"
VERSION = 1

ACCEPTED = "a file of joint commands that jtik wrote"

QUANTITIES = ("positions", "velocities", "accelerations")
PREFIXES = {"positions": "", "velocities": "velocity.", "accelerations": "acceleration."}
"""Beginnings of the titles in a table, by quantity."""
POWERS = {"positions": "", "velocities": "/s", "accelerations": "/s^2"}
"""What follows the unit of a joint, by quantity."""

LONGEST_FILE_NAME = 80


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class JointCommands:
    """What a controller of revolute and prismatic joints is given.

    Attributes:
        name: name of the attempt.
        times: time of each row (k,) [s]; the first is 0.
        positions: (k, n) [rad] and [m].
        velocities: (k, n) [rad/s] and [m/s].
        accelerations: (k, n) [rad/s^2] and [m/s^2].
        joint_names: names of the joints, in the order of the columns.
        units: unit of each joint's position, "rad" or "m".
        method: how the times were found: "toppra", "trapezoid", or "recorded" for those of the attempt.
        note: what was assumed, in sentences; empty where nothing was.
    """

    name: str
    times: Array
    positions: Array
    velocities: Array
    accelerations: Array
    joint_names: tuple[str, ...]
    units: tuple[str, ...]
    method: str = "recorded"
    note: str = ""

    def __len__(self) -> int:
        return len(self.times)

    def __repr__(self) -> str:
        return f"JointCommands({self.name!r}, {len(self)} rows, {self.duration:.3g} s, {self.method})"

    @property
    def duration(self) -> float:
        """Time of the last row [s]."""
        return float(self.times[-1])

    @property
    def configurations(self) -> Array:
        """The positions, as an attempt calls them."""
        return self.positions

    def header(self) -> dict[str, Any]:
        """Everything but the numbers, as plain data."""
        units = {name: [unit + POWERS[name] for unit in self.units] for name in QUANTITIES}
        return {
            "format": FORMAT,
            "version": VERSION,
            "name": self.name,
            "method": self.method,
            "note": self.note,
            "joint_names": list(self.joint_names),
            "units": {"times": "s", **units},
        }

    def to_json(self) -> dict[str, Any]:
        """Plain data: the header, and the arrays as lists."""
        return self.header() | {name: getattr(self, name).tolist() for name in ("times", *QUANTITIES)}


def export(commands: JointCommands, path: str | Path, format: str | None = None) -> Path:
    """Write joint commands.

    - ``"csv"``: a table with one line of titles, as ``pandas.read_csv`` reads it: "time [s]", "NAME [rad]",
      "velocity.NAME [rad/s]", "acceleration.NAME [rad/s^2]".
    - ``"json"``: an object with ``joint_names``, ``units``, ``times``, ``positions``, ``velocities``,
      ``accelerations``.
    - ``"npz"``: the same as arrays of NumPy, and ``header``, a JSON text with the rest.
    - ``"ros2_json"`` and ``"ros2_yaml"``: a message trajectory_msgs/JointTrajectory.

    Args:
        commands: the commands.
        path: the file; an existing one is replaced once all is written.
        format: one of these; by default the one of the file's suffix: csv, json, npz, or ros2_yaml for ``.yaml``.

    Returns:
        The path.

    Raises:
        ArgumentError: for another format or suffix.
        OSError: when the file cannot be written; nothing of it then stays behind.
    """
    instance("commands", commands, JointCommands, "JointCommands")
    file = read_path("path", path)
    if format is None:
        suffixes = {each.suffix: name for name, each in reversed(FORMATS.items())}
        if file.suffix not in suffixes:
            raise ArgumentError("path", str(file), f"a file name that ends in {', '.join(suffixes)}, or a format")
        format = suffixes[file.suffix]
    FORMATS[choice("format", format, tuple(FORMATS))].write(commands, file)
    return file


def load(path: str | Path) -> JointCommands:
    """Read a file of `export` in the format csv, json or npz, to the last bit.

    A table has no method and no note.

    Raises:
        ArgumentError: for any other file.
        OSError: when it cannot be read.
    """
    file = existing_file("path", path)
    readers: dict[str, Callable[[Path], dict[str, Any]]] = {
        ".csv": _read_csv,
        ".json": lambda file: dict(parsed(file.read_bytes())),
        ".npz": _read_npz,
    }
    if file.suffix not in readers:
        raise ArgumentError("path", str(file), f"a file name that ends in {', '.join(readers)}")
    try:
        found = readers[file.suffix](file)
        if found.get("format") != FORMAT or found.get("version") != VERSION:
            raise ArgumentError("path", f"{file}, which holds no joint commands of version {VERSION}", ACCEPTED)
        names, units = tuple(map(str, found["joint_names"])), tuple(map(str, found["units"]["positions"]))
        arrays = {name: np.array(found[name], dtype=np.float64) for name in ("times", *QUANTITIES)}
        shape = (len(arrays["times"]), len(names))
        if len(units) != len(names) or any(arrays[name].shape != shape for name in QUANTITIES) or not shape[0]:
            raise ArgumentError("path", f"{file}, whose columns do not fit together", ACCEPTED)
        method, note = str(found.get("method", "recorded")), str(found.get("note", ""))
        rest: dict[str, Any] = arrays | {"joint_names": names, "units": units, "method": method, "note": note}
        return JointCommands(name=str(found["name"]), **rest)
    except ArgumentError:
        raise
    except (AttributeError, IndexError, KeyError, TypeError, ValueError, RecursionError) as error:
        raise ArgumentError("path", f"{file}, which cannot be read ({str(error)[:200]})", ACCEPTED) from error


def file_name(commands: JointCommands, format: str) -> str:
    """A file name for commands in a format: letters, digits, dots and dashes of the attempt's name."""
    stem = re.sub(r"[^A-Za-z0-9.]+", "-", commands.name).strip("-.")[:LONGEST_FILE_NAME] or "attempt"
    middle = ".ros2" if format.startswith("ros2") else ""
    return f"{stem}{middle}{FORMATS[choice('format', format, tuple(FORMATS))].suffix}"


def _write_csv(commands: JointCommands, file: Path) -> None:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    titles = [
        f"{PREFIXES[name]}{joint} [{unit}{POWERS[name]}]"
        for name in QUANTITIES
        for joint, unit in zip(commands.joint_names, commands.units, strict=True)
    ]
    writer.writerow(["time [s]", *titles])
    writer.writerows(np.column_stack([commands.times, *(getattr(commands, name) for name in QUANTITIES)]).tolist())
    write_atomically(file, [text.getvalue()])


def _read_csv(file: Path) -> dict[str, Any]:
    with file.open(newline="", encoding="utf-8") as opened:
        titles, *rows = list(csv.reader(opened)) or [[]]
    n = (len(titles) - 1) // 3
    joints = [re.fullmatch(r"(.*) \[(rad|m)\]", title) for title in titles[1 : 1 + n]]
    if titles[:1] != ["time [s]"] or len(titles) != 1 + 3 * n or not n or None in joints:
        raise ArgumentError("path", f"{file}, whose titles are {titles[:5]}", f"{ACCEPTED}: 'time [s]', 'NAME [rad]'")
    table = np.array(rows, dtype=np.float64).reshape(len(rows), len(titles))
    parts = {name: table[:, 1 + i * n : 1 + (i + 1) * n] for i, name in enumerate(QUANTITIES)}
    found = [joint.groups() for joint in joints if joint is not None]
    return {
        "format": FORMAT,
        "version": VERSION,
        "name": file.stem,
        "joint_names": [name for name, _ in found],
        "units": {"positions": [unit for _, unit in found]},
        "times": table[:, 0],
        **parts,
    }


def _write_json(commands: JointCommands, file: Path) -> None:
    write_atomically(file, [json.dumps(commands.to_json(), allow_nan=False), "\n"])


def _write_npz(commands: JointCommands, file: Path) -> None:
    write_archive(file, commands.header(), {name: getattr(commands, name) for name in ("times", *QUANTITIES)})


def _read_npz(file: Path) -> dict[str, Any]:
    header, arrays = read_archive(file, "path", ACCEPTED)
    return header | arrays


def _message(commands: JointCommands) -> dict[str, Any]:
    rows = [getattr(commands, name) for name in QUANTITIES]
    return ros2.message(commands.joint_names, commands.times, *rows)


def _write_ros2_json(commands: JointCommands, file: Path) -> None:
    write_atomically(file, [json.dumps(_message(commands), allow_nan=False), "\n"])


def _write_ros2_yaml(commands: JointCommands, file: Path) -> None:
    write_atomically(file, [ros2.as_yaml(_message(commands)), "\n"])


class _Format(NamedTuple):
    suffix: str
    write: Callable[[JointCommands, Path], None]


FORMATS = {
    "csv": _Format(".csv", _write_csv),
    "json": _Format(".json", _write_json),
    "npz": _Format(".npz", _write_npz),
    "ros2_json": _Format(".json", _write_ros2_json),
    "ros2_yaml": _Format(".yaml", _write_ros2_yaml),
}
"""How joint commands are written, by the name of the format."""
