"""Result files of studies: one ``.npz`` with arrays and a JSON header, without pickles, replaced atomically."""

from __future__ import annotations

import time
import warnings
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jtik._loop.options import callers_level
from jtik.errors import ArgumentError
from jtik.plotting.obstacles_in import obstacles_in
from jtik.problems import ProblemSet
from jtik.result.archive import checked_path, read_archive, write_archive
from jtik.result.solution import Trace
from jtik.robot import Robot
from jtik.study.comparison import Comparison, assembled
from jtik.study.plain_data import DescriptionError, as_data, from_data
from jtik.study.rows import COLUMNS, TEXTS, Row
from jtik.study.work_units import StudyPlan, UnitResult
from jtik.symbolic import symbol
from jtik.task import Task, TaskStack
from jtik.types import Array

ACCEPTED = "a file that Comparison.save or jtik.compare(save=...) wrote"

SHOWN = 200
"""Longest part of an error's text that is repeated, in characters."""

FORMAT = 1
"""Version of the file format."""

PAUSE = 5.0
"""Smallest time between two writes of a running study [s]."""

SHARE = 0.05
"""Largest share of the time that is spent on writing."""


def write(comparison: Comparison, path: str | Path) -> None:
    """Write a file that `read` reads."""
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
        "obstacles": {
            label: {name: value.tolist() for name, value in own.items()} for label, own in comparison.obstacles.items()
        },
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
    write_archive(path, header, arrays)


def read(path: str | Path, argument: str = "path") -> Comparison:
    """Read a file of `write`. Raises ArgumentError for any other file."""
    path = checked_path(path, argument)
    header, arrays = read_archive(path, argument, ACCEPTED)
    version = header.get("format")
    if version is None or "problems" not in header:
        raise ArgumentError(argument, f"{path}, which holds no study", ACCEPTED)
    if version != FORMAT:
        raise ArgumentError(argument, f"{path} of format {version}", f"format {FORMAT}")
    try:
        return _checked(_comparison(header, arrays))
    except Exception as error:  # what is built from a file that somebody has changed may raise anything
        given = f"{path}, whose parts do not fit together ({type(error).__name__}: {str(error)[:SHOWN]})"
        raise ArgumentError(argument, given, ACCEPTED) from error


def _comparison(header: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> Comparison:
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
        obstacles={
            label: {name: np.array(value, dtype=np.float64) for name, value in own.items()}
            for label, own in header.get("obstacles", {}).items()
        },
        settings=header["settings"],
        machine=header["machine"],
        complete=header["complete"],
        fingerprint=header["fingerprint"],
    )


def _checked(found: Comparison) -> Comparison:
    """The comparison. Raises some error where its parts have wrong types or sizes, or cannot be shown."""
    _require(isinstance(found.robot, Robot), "robot")
    _require(isinstance(found.tasks, tuple) and all(isinstance(task, Task) for task in found.tasks), "tasks")
    _require(isinstance(found.settings, dict) and isinstance(found.machine, dict), "settings")
    _require(isinstance(found.complete, bool) and isinstance(found.fingerprint, str), "fingerprint")
    rows = len(found.answers)
    _require(found.answers.shape == (rows, found.robot.nq) and found.answers.dtype == np.float64, "answers")
    for name, column in found.columns.items():
        kind = "U" if name in TEXTS else "b" if name == "success" else "f"
        _require(column.shape == (rows,) and column.dtype.kind == kind, name)
    for own in found.obstacles.values():
        _ = obstacles_in(own)
    for postures in found.paths.values():
        _require(postures.ndim == 2 and postures.shape[1] == found.robot.nq, "paths")
    if found.tasks:
        stack = TaskStack.of(found.robot, found.tasks)
        stack.rows(found.robot.at(symbol("q", found.robot.nq)), symbol("target", stack.target_size))
    _ = repr(found), found.settings.get("study")
    return found


def _require(fits: bool, part: str) -> None:
    if not fits:
        raise ValueError(f"its {part}")


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
        if self._path is None or time.monotonic() - self._written <= self._pause:
            return
        begin = time.monotonic()
        with suppress(OSError):  # perhaps there is room later; the last write reports it
            self._write(self._path)
        self._written = time.monotonic()
        self._pause = max(PAUSE, (self._written - begin) / SHARE)

    def write(self) -> None:
        """Write all results if there are new ones; a warning says why where that is not possible."""
        if self._path is None or (self._count == len(self.results) and self._path.exists()):
            return
        try:
            self._write(self._path)
        except OSError as error:
            advice = "Comparison.save writes it elsewhere"
            warnings.warn(f"the study was not saved: {error}; {advice}", RuntimeWarning, stacklevel=callers_level())

    def _write(self, path: Path) -> None:
        write(self.comparison(), path)
        self._count = len(self.results)

    def comparison(self) -> Comparison:
        """The results so far as a Comparison."""
        complete = len(self.results) == len(self._plan.units())
        return assembled(self._plan, self.results, complete=complete, **self._known)

    def _finished_units(self, path: Path) -> list[UnitResult]:
        """The units that are complete in a file."""
        found = read(path, "save")
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
