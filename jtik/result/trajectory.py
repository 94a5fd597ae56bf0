"""Joint motion along a path of targets, and its files."""

from __future__ import annotations

import csv
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from jtik.errors import ArgumentError
from jtik.result.solution import Status
from jtik.types import Array


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Joint motion along a path of targets, as `InverseKinematics.track` returns it.

    Attributes:
        times: (k,) [s]; the start is at time 0 and not a row.
        q: (k, nq) [rad] and [m].
        dq: mean velocity on the way to each row, (k, n) [rad/s] and [m/s].
        errors: norm of the task error at each target, (k,) [m] and [rad] together.
        statuses: how the solve at each target ended.
        iterations: steps tried for each target, (k,).
        seconds: wall time of each solve, (k,) [s].
        joint_names: the joints that q belongs to, in its order.
    """

    times: Array
    q: Array
    dq: Array
    errors: Array
    statuses: tuple[Status, ...]
    iterations: NDArray[np.int64]
    seconds: Array
    joint_names: tuple[str, ...]

    @property
    def converged(self) -> bool:
        """Whether every target was reached."""
        return all(status in (Status.CONVERGED, Status.REACHED) for status in self.statuses)

    def __len__(self) -> int:
        return len(self.times)

    def __repr__(self) -> str:
        reached = sum(status in (Status.CONVERGED, Status.REACHED) for status in self.statuses)
        worst = float(self.errors.max()) if len(self) else 0.0
        return (
            f"Trajectory: {reached} of {len(self)} targets reached, {self.times[-1]:.3g} s, largest error {worst:.3g}"
        )

    def save(self, path: str | Path) -> None:
        """Write it to a ``.npz`` or a ``.csv`` file; `load` reads both back to the last bit.

        Raises:
            ArgumentError: for another suffix.
        """
        path = _file(path)
        columns = self._columns()
        if path.suffix == ".npz":
            np.savez(path, allow_pickle=False, **columns)
            return
        table: dict[str, NDArray[np.generic]] = {}
        for name, column in columns.items():
            if name == "joint_names":
                continue
            if column.ndim == 1:
                table[name] = column
            else:
                table |= {f"{name}[{i}]": column[:, i] for i in range(column.shape[1])}
        with path.open("w", newline="", encoding="utf-8") as file:
            file.write(f"{_JOINTS}{','.join(self.joint_names)}\n")
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(table)
            writer.writerows(zip(*[column.tolist() for column in table.values()], strict=True))

    @classmethod
    def load(cls, path: str | Path) -> Trajectory:
        """Read what `save` wrote.

        Raises:
            ArgumentError: for another suffix, or a file that is not a trajectory.
            OSError: when the file cannot be read.
        """
        path = _file(path)
        columns = _read_npz(path) if path.suffix == ".npz" else _read_csv(path)
        missing = [field.name for field in fields(cls) if field.name not in columns]
        if missing:
            raise ArgumentError("path", path, f"a file that Trajectory.save wrote; it lacks {', '.join(missing)}")
        statuses = [str(name) for name in columns["statuses"]]
        unknown = sorted(set(statuses) - set(Status.__members__))
        if unknown:
            raise ArgumentError("path", f"{path} with status {unknown[0]!r}", f"one of {', '.join(Status.__members__)}")
        return cls(
            times=columns["times"].astype(np.float64),
            q=columns["q"].astype(np.float64),
            dq=columns["dq"].astype(np.float64),
            errors=columns["errors"].astype(np.float64),
            statuses=tuple(Status[name] for name in statuses),
            iterations=columns["iterations"].astype(np.int64),
            seconds=columns["seconds"].astype(np.float64),
            joint_names=tuple(str(name) for name in columns["joint_names"]),
        )

    def _columns(self) -> dict[str, NDArray[np.generic]]:
        return {
            "times": self.times,
            "q": self.q,
            "dq": self.dq,
            "errors": self.errors,
            "statuses": np.array([status.name for status in self.statuses]),
            "iterations": self.iterations,
            "seconds": self.seconds,
            "joint_names": np.array(self.joint_names),
        }


_JOINTS = "# joints: "


def _file(path: str | Path) -> Path:
    path = Path(path)
    if path.suffix not in (".npz", ".csv"):
        raise ArgumentError("path", path, "a file name that ends in .npz or .csv")
    return path


def _read_npz(path: Path) -> dict[str, NDArray[np.generic]]:
    try:
        with np.load(path, allow_pickle=False) as archive:
            return dict(archive)
    except ValueError as error:
        raise ArgumentError("path", path, "a file that Trajectory.save wrote") from error


def _read_csv(path: Path) -> dict[str, NDArray[np.generic]]:
    with path.open(newline="", encoding="utf-8") as file:
        first = file.readline().rstrip("\n")
        if not first.startswith(_JOINTS):
            raise ArgumentError("path", path, f"a file that Trajectory.save wrote; its first line begins {_JOINTS!r}")
        header, *rows = list(csv.reader(file))
    if any(len(row) != len(header) for row in rows):
        raise ArgumentError("path", path, f"rows of {len(header)} values, one for each column")
    table = dict(zip(header, np.array(rows).reshape(len(rows), len(header)).T, strict=True))
    columns: dict[str, NDArray[np.generic]] = {"joint_names": np.array(first.removeprefix(_JOINTS).split(","))}
    for name in ("times", "errors", "statuses", "iterations", "seconds"):
        if name in table:
            columns[name] = table[name]
    for name in ("q", "dq"):
        entries = [table[key] for key in header if key.startswith(f"{name}[")]
        if entries:
            columns[name] = np.stack(entries, axis=1)
    return columns
