"""Files of trajectories: ``.csv`` tables, ``.json`` objects and ``.npz`` archives."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from jtik.arguments import existing_file
from jtik.arguments import path as read_path
from jtik.errors import ArgumentError
from jtik.result import trajectory_csv
from jtik.result.status import Status
from jtik.result.trajectory import Trajectory

Column = NDArray[np.generic]

RENAMED = {"errors": "error_norm", "statuses": "status"}
"""Columns that files of earlier versions have under another name."""

ADDED = ("position_error", "orientation_error")
"""Columns that files of earlier versions do not have: NaN."""


def save(trajectory: Trajectory, path: str | Path) -> None:
    """Write a trajectory. Raises ArgumentError for a suffix other than those of `FORMATS`."""
    path = _file(path)
    columns: dict[str, Column] = {field.name: np.array(getattr(trajectory, field.name)) for field in fields(trajectory)}
    columns["complete"] = np.array([trajectory.complete])
    columns["status"] = np.array([status.name for status in trajectory.status])
    FORMATS[path.suffix].write(path, columns)


def load(path: str | Path) -> Trajectory:
    """Read a trajectory. Raises ArgumentError for another suffix or a file that is not a trajectory."""
    path = existing_file("path", _file(path))
    columns = FORMATS[path.suffix].read(path)
    columns = {RENAMED.get(name, name): column for name, column in columns.items()}
    columns = {**_defaults(columns), **columns}
    missing = [field.name for field in fields(Trajectory) if field.name not in columns]
    if missing:
        raise ArgumentError("path", path, f"a file that Trajectory.save wrote; it lacks {', '.join(missing)}")
    _check_shapes(path, columns)
    names = [str(name) for name in columns["status"]]
    unknown = sorted(set(names) - set(Status.__members__))
    if unknown:
        raise ArgumentError("path", f"{path} with status {unknown[0]!r}", f"one of {', '.join(Status.__members__)}")
    return Trajectory(
        times=columns["times"].astype(np.float64),
        start=columns["start"].astype(np.float64),
        q=columns["q"].astype(np.float64),
        dq=columns["dq"].astype(np.float64),
        error_norm=columns["error_norm"].astype(np.float64),
        position_error=columns["position_error"].astype(np.float64),
        orientation_error=columns["orientation_error"].astype(np.float64),
        status=tuple(Status[name] for name in names),
        iterations=columns["iterations"].astype(np.int64),
        seconds=columns["seconds"].astype(np.float64),
        joint_names=tuple(str(name) for name in columns["joint_names"]),
        joint_sizes=tuple(int(size) for size in columns["joint_sizes"]),
        complete=bool(columns["complete"].all()),
    )


def _check_shapes(path: Path, columns: dict[str, Column]) -> None:
    """Raise ArgumentError unless the columns have one row for each target, and q one number for each of the joints."""
    k, width = len(np.atleast_1d(columns["times"])), np.shape(columns["start"])
    for name, column in columns.items():
        matrix, joints = name in ("q", "dq"), name in ("start", "joint_names", "joint_sizes", "complete")
        right = column.ndim == (2 if matrix else 1) and (joints or len(column) == k)
        if not right or (name == "q" and column.shape[1:] != width):
            raise ArgumentError("path", f"{path} with {name} of shape {column.shape}", "a file of Trajectory.save")


def _defaults(columns: dict[str, Column]) -> dict[str, Column]:
    """What files of earlier versions lack."""
    found: dict[str, Column] = {"complete": np.array([True])}
    if "times" in columns:
        found |= {name: np.full(len(columns["times"]), np.nan) for name in ADDED}
    if "q" in columns and "joint_names" in columns:
        width, joints = columns["q"].shape[-1], len(columns["joint_names"])
        found["start"] = np.full(width, np.nan)
        found["joint_sizes"] = np.ones(joints if joints == width else 0, dtype=int)
    return found


def _file(path: str | Path) -> Path:
    path = read_path("path", path)
    if path.suffix not in FORMATS:
        raise ArgumentError("path", path, f"a file name that ends in {', '.join(FORMATS)}")
    return path


def _write_npz(path: Path, columns: dict[str, Column]) -> None:
    np.savez(path, allow_pickle=False, **columns)


def _read_npz(path: Path) -> dict[str, Column]:
    try:
        with np.load(path, allow_pickle=False) as archive:
            return dict(archive)
    except ValueError as error:
        raise ArgumentError("path", path, "a file that Trajectory.save wrote") from error


def _write_json(path: Path, columns: dict[str, Column]) -> None:
    document = {name: _finite(column.tolist()) for name, column in columns.items()}
    path.write_text(json.dumps(document, allow_nan=False) + "\n", encoding="utf-8")


def _read_json(path: Path) -> dict[str, Column]:
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
        texts = ("status", "joint_names")
        return {name: np.array(value, dtype=str if name in texts else float) for name, value in document.items()}
    except (AttributeError, TypeError, ValueError, RecursionError) as error:  # not JSON, no object, other values
        raise ArgumentError("path", path, f"a file that Trajectory.save wrote; {error}") from error


def _finite(value: Any) -> Any:
    """The value with null for what JSON has no number for."""
    if isinstance(value, list):
        return [_finite(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


class _Format(NamedTuple):
    write: Callable[[Path, dict[str, Column]], None]
    read: Callable[[Path], dict[str, Column]]


FORMATS = {
    ".csv": _Format(trajectory_csv.write, trajectory_csv.read),
    ".json": _Format(_write_json, _read_json),
    ".npz": _Format(_write_npz, _read_npz),
}
"""How a trajectory is written and read, by the suffix of the file."""
