"""Result files of studies: one ``.npz`` with arrays and a JSON header, without pickles, replaced atomically."""

from __future__ import annotations

import json
import os
import time
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jtik.arguments import existing_file
from jtik.arguments import path as read_path
from jtik.errors import ArgumentError
from jtik.problems import ProblemSet
from jtik.result.solution import Trace
from jtik.study.comparison import Comparison, assembled
from jtik.study.plain_data import DescriptionError, as_data, from_data
from jtik.study.rows import COLUMNS, Row
from jtik.study.work_units import StudyPlan, UnitResult
from jtik.types import Array

FORMAT = 1
"""Version of the file format."""

PAUSE = 5.0
"""Smallest time between two writes of a running study [s]."""

SHARE = 0.05
"""Largest share of the time that is spent on writing."""


def checked_path(path: str | Path, argument: str = "path") -> Path:
    """The path. Raises ArgumentError unless it ends in .npz and its folder exists."""
    path = read_path(argument, path)
    if path.suffix != ".npz":
        raise ArgumentError(argument, str(path), "a file name that ends in .npz")
    if not path.parent.is_dir():
        raise ArgumentError(argument, str(path), "a file in an existing folder")
    return path


def write(comparison: Comparison, path: str | Path) -> None:
    """Write to a temporary file and rename it, so that a reader finds either the old or the new file."""
    path = checked_path(path)
    try:
        tasks = as_data(comparison.tasks)
    except DescriptionError:
        tasks = None
    header = {
        "format": FORMAT,
        "robot": as_data(comparison.robot),
        "tasks": tasks,
        "problems": comparison.problems.as_data(),
        "settings": dict(comparison.settings),
        "machine": dict(comparison.machine),
        "complete": comparison.complete,
        "fingerprint": comparison.fingerprint,
        "traces": [[*key, list(trace.figures)] for key, trace in comparison.traces.items()],
        "paths": [list(key) for key in comparison.paths],
    }
    arrays: dict[str, NDArray[Any]] = {f"column/{name}": column for name, column in comparison.columns.items()}
    arrays["answers"] = comparison.answers
    arrays |= {f"trace/{i}": _serialized(trace) for i, trace in enumerate(comparison.traces.values())}
    arrays |= {f"path/{i}": postures for i, postures in enumerate(comparison.paths.values())}
    temporary = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        with temporary.open("wb") as file:
            np.savez(file, allow_pickle=False, header=np.array(json.dumps(header)), **arrays)
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def read(path: str | Path) -> Comparison:
    """Read a file of `write`. Raises ArgumentError for any other file."""
    path = existing_file("path", checked_path(path))
    accepted = "a file that Comparison.save or jtik.compare(save=...) wrote"
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as archive:
            arrays = dict(archive)
        header = json.loads(str(arrays.pop("header")))
        version = header["format"]
    except (ValueError, KeyError, zipfile.BadZipFile, EOFError) as error:
        raise ArgumentError("path", str(path), accepted) from error
    if version != FORMAT:
        raise ArgumentError("path", f"{path} of format {version}", f"format {FORMAT}")
    traces = {
        (contender, criteria, case): _unpacked(arrays[f"trace/{i}"], figures)
        for i, (contender, criteria, case, figures) in enumerate(header["traces"])
    }
    return Comparison(
        columns={name: arrays[f"column/{name}"] for name in COLUMNS},
        answers=arrays["answers"],
        traces=traces,
        paths={(key[0], key[1], key[2]): arrays[f"path/{i}"] for i, key in enumerate(header["paths"])},
        robot=from_data(header["robot"]),
        tasks=() if header["tasks"] is None else from_data(header["tasks"]),
        problems=ProblemSet.from_data(header["problems"]),
        settings=header["settings"],
        machine=header["machine"],
        complete=header["complete"],
        fingerprint=header["fingerprint"],
    )


def _serialized(trace: Trace) -> Array:
    """A trace as one table: q, error and figures, which are NaN in the last row."""
    columns = [np.append(figure, np.nan) for figure in trace.figures.values()]
    return np.column_stack([trace.q, trace.error, *columns])


def _unpacked(table: Array, names: Sequence[str]) -> Trace:
    nq = table.shape[1] - 1 - len(names)
    figures = {name: table[:-1, nq + 1 + i].copy() for i, name in enumerate(names)}
    return Trace(q=table[:, :nq].copy(), error=table[:, nq].copy(), figures=figures)


class ResultFile:
    """The results of a running study, written to a file, with the results that the file already had.

    Args:
        path: the file; None writes nothing.
        plan: the study.
        known: the attributes of `Comparison` that do not follow from the plan, such as its fingerprint.

    Attributes:
        results: the results of the completed units.

    Raises:
        ArgumentError: for a file that holds another study, or no study.
    """

    def __init__(self, path: str | Path | None, plan: StudyPlan, known: Mapping[str, Any]) -> None:
        self._path = None if path is None else checked_path(path, "save")
        self._plan, self._known = plan, known
        self.results: list[UnitResult] = []
        self._written = time.monotonic()
        self._pause = PAUSE
        if self._path is not None and self._path.exists():
            self.results = self._finished_units(self._path)
        self._count = len(self.results)

    def add(self, result: UnitResult) -> None:
        """Add a result, and write all results unless the last write was recent."""
        self.results.append(result)
        if self._path is not None and time.monotonic() - self._written > self._pause:
            self.write()

    def write(self) -> None:
        """Write all results if there are new ones."""
        if self._path is None or (self._count == len(self.results) and self._path.exists()):
            return
        begin = time.monotonic()
        write(self.comparison(), self._path)
        self._written = time.monotonic()
        self._pause = max(PAUSE, (self._written - begin) / SHARE)
        self._count = len(self.results)

    def comparison(self) -> Comparison:
        """The results so far as a Comparison."""
        complete = len(self.results) == len(self._plan.units())
        return assembled(self._plan, self.results, complete=complete, **self._known)

    def _finished_units(self, path: Path) -> list[UnitResult]:
        """The units that are complete in a file."""
        found = read(path)
        if found.fingerprint != self._known["fingerprint"]:
            given = f"{path}, which holds another study: {found.settings.get('study', found)}"
            raise ArgumentError("save", given, "a file of the same study, or a new file")
        every, results = _rows(found), []
        rows = {(row.contender, row.criteria, row.case): i for i, row in enumerate(every)}
        for unit in self._plan.units():
            names = [case.name for case in self._plan.problems.cases[unit.start : unit.stop]]
            keys = [(contender, unit.criteria, name) for contender in self._plan.contenders for name in names]
            if all(key in rows for key in keys):
                own = set(keys)
                results.append(
                    UnitResult(
                        unit,
                        [every[rows[key]] for key in keys],
                        [found.answers[rows[key]] for key in keys],
                        {key: trace for key, trace in found.traces.items() if key in own},
                        {key: postures for key, postures in found.paths.items() if key in own},
                    )
                )
        return results


def _rows(comparison: Comparison) -> list[Row]:
    columns = {name: column.tolist() for name, column in comparison.columns.items()}
    return [Row(**dict(zip(columns, values, strict=True))) for values in zip(*columns.values(), strict=True)]
