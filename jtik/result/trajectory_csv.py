"""Trajectories as ``.csv`` tables: one line of titles, the start, and one row for each target."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from jtik.errors import ArgumentError

Column = NDArray[np.generic]

TIME = "time"
VELOCITY = "velocity."
"""Beginning of the title of a velocity; the title of the position follows."""

FIGURES = ("error_norm", "position_error", "orientation_error", "status", "iterations", "seconds")
"""Titles of the last columns."""

START = "START"
"""Status of the row of the start."""

_JOINT = " (joint)"
_ENTRY = re.compile(r"(.*)\[(\d+)\]")

_FORMER = "# joints: "
"""Beginning of the first line in files of earlier versions; the names of the joints follow."""


def write(path: Path, columns: dict[str, Column]) -> None:
    """Write the attributes of a trajectory.

    Args:
        path: the file.
        columns: the attributes as arrays.

    Raises:
        ArgumentError: when the joints do not say how many numbers of q each of them has.
    """
    sizes = columns["joint_sizes"].tolist()
    if sum(sizes) != columns["q"].shape[1]:
        raise ArgumentError("path", path, "a .json or .npz file, as this trajectory does not have joint_sizes")
    joints = list(zip(map(_title, columns["joint_names"].tolist()), sizes, strict=True))
    positions = [title for joint, size in joints for title in _entries(joint, size)]
    velocities = [VELOCITY + title for joint, size in joints for title in _entries(joint, size - (size > 1))]
    start = [0.0, *columns["start"].tolist(), *[0.0] * len(velocities), "", "", "", START, 0, 0.0]
    rows = zip(
        columns["times"].tolist(),
        columns["q"].tolist(),
        columns["dq"].tolist(),
        *[columns[name].tolist() for name in FIGURES],
        strict=True,
    )
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([TIME, *positions, *velocities, *FIGURES])
        if not np.isnan(columns["start"].astype(float)).any():
            writer.writerow(start)
        writer.writerows([time, *q, *dq, *map(_cell, figures)] for time, q, dq, *figures in rows)


def read(path: Path) -> dict[str, Column]:
    """The attributes as arrays, of this version or an earlier one. Raises ArgumentError for another file."""
    try:
        with path.open(newline="", encoding="utf-8") as file:
            lines = list(csv.reader(file))
    except (ValueError, csv.Error) as error:
        raise _refused(path, f"; {error}") from error
    if lines and lines[0] and lines[0][0].startswith(_FORMER):
        return _read_former(path, lines)
    titles, *rows = lines or [[]]
    _check_rows(path, titles, rows)
    given, figures = titles[1 : -len(FIGURES)], titles[-len(FIGURES) :]
    positions = given[: given.index(VELOCITY + given[0])] if given and VELOCITY + given[0] in given else []
    if titles[:1] != [TIME] or tuple(figures) != FIGURES or not positions:
        raise _refused(path, f", whose titles are {TIME}, the joints, their velocities, {', '.join(FIGURES)}")
    table = np.array(rows, dtype=object).reshape(len(rows), len(titles))
    started = len(rows) > 0 and rows[0][-3] == START
    body = table[1:] if started else table
    names, sizes = _joints(positions)
    width = len(positions)
    columns: dict[str, Column] = {
        "times": _numbers(path, body[:, 0]),
        "start": _numbers(path, table[0, 1 : 1 + width]) if started else np.full(width, np.nan),
        "q": _numbers(path, body[:, 1 : 1 + width]),
        "dq": _numbers(path, body[:, 1 + width : -len(FIGURES)]),
        "status": np.array([row[-3] for row in body.tolist()], dtype=str),
        "joint_names": np.array(names),
        "joint_sizes": np.array(sizes),
    }
    for place, name in enumerate(FIGURES, start=len(titles) - len(FIGURES)):
        if name != "status":
            columns[name] = _numbers(path, body[:, place])
    return columns


def _title(joint: str) -> str:
    """The title of a joint: its name, marked where it could be read as something else."""
    known = joint == TIME or joint in FIGURES or joint.startswith(VELOCITY)
    return joint + _JOINT if known or joint.endswith(_JOINT) or _ENTRY.fullmatch(joint) else joint


def _entries(joint: str, size: int) -> list[str]:
    return [joint] if size == 1 else [f"{joint}[{i}]" for i in range(size)]


def _joints(titles: Sequence[str]) -> tuple[list[str], list[int]]:
    """Names of the joints and how many numbers each has, from the titles of the positions."""
    names: list[str] = []
    sizes: list[int] = []
    for title in titles:
        entry = _ENTRY.fullmatch(title)
        if entry is not None and entry[2] != "0" and sizes:
            sizes[-1] += 1
            continue
        names.append((entry[1] if entry is not None else title).removesuffix(_JOINT))
        sizes.append(1)
    return names, sizes


def _cell(value: object) -> object:
    """The value; an empty cell for NaN."""
    return "" if isinstance(value, float) and value != value else value


def _numbers(path: Path, cells: NDArray[np.object_]) -> Column:
    """The cells as numbers, NaN for empty ones."""
    try:
        return np.where(cells == "", "nan", cells).astype(str).astype(np.float64)
    except ValueError as error:
        raise _refused(path, f", with numbers; {error}") from error


def _check_rows(path: Path, titles: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    if any(len(row) != len(titles) for row in rows):
        raise ArgumentError("path", path, f"rows of {len(titles)} values, one for each column")


def _refused(path: Path, more: str = "") -> ArgumentError:
    return ArgumentError("path", path, f"a file that Trajectory.save wrote{more}")


def _read_former(path: Path, lines: list[list[str]]) -> dict[str, Column]:
    """The columns of a file of an earlier version: the joints in a first line, and no start."""
    first, header, *rows = lines if len(lines) > 1 else [*lines, []]
    _check_rows(path, header, rows)
    table = dict(zip(header, np.array(rows).reshape(len(rows), len(header)).T, strict=True))
    columns: dict[str, Column] = {name: column for name, column in table.items() if "[" not in name}
    columns["joint_names"] = np.array(",".join(first).removeprefix(_FORMER).split(","))
    for name in ("q", "dq"):
        entries = [table[key] for key in header if key.startswith(f"{name}[")]
        if entries:
            columns[name] = np.stack(entries, axis=1)
    return columns
