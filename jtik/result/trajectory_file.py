"""Files of trajectories: ``.npz`` archives and ``.csv`` tables."""

from __future__ import annotations

import csv
from dataclasses import fields
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from jtik.arguments import existing_file
from jtik.arguments import path as read_path
from jtik.errors import ArgumentError
from jtik.result.status import Status
from jtik.result.trajectory import Trajectory

Column = NDArray[np.generic]

JOINTS = "# joints: "
"""Beginning of the first line of a ``.csv`` file; the names of the joints follow."""

RENAMED = {"errors": "error_norm", "statuses": "status"}
"""Columns that files of earlier versions have under another name."""

ADDED = ("position_error", "orientation_error")
"""Columns that files of earlier versions do not have: NaN."""

MATRICES = ("q", "dq")
"""Columns with several numbers a row: one column each in a ``.csv`` file, such as ``q[0]``."""


def save(trajectory: Trajectory, path: str | Path) -> None:
    """Write a trajectory. Raises ArgumentError for a suffix other than ``.npz`` or ``.csv``."""
    path = _file(path)
    columns: dict[str, Column] = {field.name: getattr(trajectory, field.name) for field in fields(trajectory)}
    columns["status"] = np.array([status.name for status in trajectory.status])
    columns["joint_names"] = np.array(trajectory.joint_names)
    if path.suffix == ".npz":
        np.savez(path, allow_pickle=False, **columns)
    else:
        _write_csv(path, columns)


def load(path: str | Path) -> Trajectory:
    """Read a trajectory. Raises ArgumentError for another suffix or a file that is not a trajectory."""
    path = existing_file("path", _file(path))
    columns = _read_npz(path) if path.suffix == ".npz" else _read_csv(path)
    columns = {RENAMED.get(name, name): column for name, column in columns.items()}
    if "times" in columns:
        columns = {name: np.full(len(columns["times"]), np.nan) for name in ADDED} | columns
    missing = [field.name for field in fields(Trajectory) if field.name not in columns]
    if missing:
        raise ArgumentError("path", path, f"a file that Trajectory.save wrote; it lacks {', '.join(missing)}")
    names = [str(name) for name in columns["status"]]
    unknown = sorted(set(names) - set(Status.__members__))
    if unknown:
        raise ArgumentError("path", f"{path} with status {unknown[0]!r}", f"one of {', '.join(Status.__members__)}")
    return Trajectory(
        times=columns["times"].astype(np.float64),
        q=columns["q"].astype(np.float64),
        dq=columns["dq"].astype(np.float64),
        error_norm=columns["error_norm"].astype(np.float64),
        position_error=columns["position_error"].astype(np.float64),
        orientation_error=columns["orientation_error"].astype(np.float64),
        status=tuple(Status[name] for name in names),
        iterations=columns["iterations"].astype(np.int64),
        seconds=columns["seconds"].astype(np.float64),
        joint_names=tuple(str(name) for name in columns["joint_names"]),
    )


def _file(path: str | Path) -> Path:
    path = read_path("path", path)
    if path.suffix not in (".npz", ".csv"):
        raise ArgumentError("path", path, "a file name that ends in .npz or .csv")
    return path


def _write_csv(path: Path, columns: dict[str, Column]) -> None:
    """A first line with the joints, a line of column names, and one line a target."""
    joints = columns.pop("joint_names")
    table: dict[str, Column] = {}
    for name, column in columns.items():
        if name in MATRICES:
            table |= {f"{name}[{i}]": column[:, i] for i in range(column.shape[1])}
        else:
            table[name] = column
    with path.open("w", newline="", encoding="utf-8") as file:
        file.write(f"{JOINTS}{','.join(joints.tolist())}\n")
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(table)
        writer.writerows(zip(*[column.tolist() for column in table.values()], strict=True))


def _read_npz(path: Path) -> dict[str, Column]:
    try:
        with np.load(path, allow_pickle=False) as archive:
            return dict(archive)
    except ValueError as error:
        raise ArgumentError("path", path, "a file that Trajectory.save wrote") from error


def _read_csv(path: Path) -> dict[str, Column]:
    with path.open(newline="", encoding="utf-8") as file:
        first = file.readline().rstrip("\n")
        if not first.startswith(JOINTS):
            raise ArgumentError("path", path, f"a file that Trajectory.save wrote; its first line begins {JOINTS!r}")
        header, *rows = list(csv.reader(file))
    if any(len(row) != len(header) for row in rows):
        raise ArgumentError("path", path, f"rows of {len(header)} values, one for each column")
    table = dict(zip(header, np.array(rows).reshape(len(rows), len(header)).T, strict=True))
    columns: dict[str, Column] = {name: column for name, column in table.items() if "[" not in name}
    columns["joint_names"] = np.array(first.removeprefix(JOINTS).split(","))
    for name in MATRICES:
        entries = [table[key] for key in header if key.startswith(f"{name}[")]
        if entries:
            columns[name] = np.stack(entries, axis=1)
    return columns
