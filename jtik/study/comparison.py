"""The result of a study: one row for each contender and case, with summary tables, figures and files."""

from __future__ import annotations

import csv
import html
import textwrap
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from jtik.errors import MissingExtraError
from jtik.problems import ProblemSet
from jtik.registry.citation import Citations
from jtik.result.solution import Trace
from jtik.robot import Robot
from jtik.study import tables
from jtik.study.rows import COLUMNS, FAILURES, FALSE_SUCCESS, OLD_FALSE_SUCCESS, TEXTS
from jtik.study.summary import DROPPED_FIRST, summary
from jtik.task import Task
from jtik.types import Array

if TYPE_CHECKING:
    import pandas

    from jtik.plotting import Figure
    from jtik.study.work_units import Key, StudyPlan, UnitResult


@dataclass(frozen=True, eq=False, repr=False)
class Comparison:
    """The result of `jtik.compare`. A row is one contender with one set of criteria on one case.

    Options of figures: ``contenders`` are names, all by default; ``criteria``, ``case`` and ``contender`` are one name,
    the first by default; ``kind`` is a kind of cases, all by default. A figure raises ArgumentError where nothing was
    recorded, and UnknownNameError for an unknown name.

    Attributes:
        columns: arrays by column name, as documented in `jtik.study.Row`.
        answers: final configuration of each row, (rows, nq), NaN if there is none.
        traces: iterations by (contender, criteria, case), for the first cases of each kind.
        paths: configurations along paths (k, nq) by the same key, for the first cases of each kind.
        robot: the reduced robot, to which q belongs.
        tasks: the tasks; empty if loaded from a file that could not store a custom task.
        problems: the cases.
        obstacles: live parameters of criteria and clearances that describe obstacles, by label of the criteria; those
            of a case take precedence.
        settings: options of the study, as strings and numbers.
        machine: platform and package versions.
        complete: whether all units of the study are included.
        fingerprint: hash of the study; equal for equal studies.
    """

    columns: Mapping[str, NDArray[Any]]
    answers: Array
    traces: Mapping[Key, Trace]
    paths: Mapping[Key, Array]
    robot: Robot
    tasks: tuple[Task, ...]
    problems: ProblemSet
    obstacles: Mapping[str, Mapping[str, Array]] = field(default_factory=dict)
    settings: Mapping[str, Any] = field(default_factory=dict)
    machine: Mapping[str, str] = field(default_factory=dict)
    complete: bool = True
    fingerprint: str = ""

    def __len__(self) -> int:
        return len(self.answers)

    @property
    def task(self) -> Task | tuple[Task, ...]:
        """The task, or a tuple of several tasks."""
        return self.tasks[0] if len(self.tasks) == 1 else self.tasks

    @property
    def contenders(self) -> tuple[str, ...]:
        """The labels of the contenders in the given order."""
        return tuple(dict.fromkeys(self.columns["contender"].tolist()))

    @property
    def criteria(self) -> tuple[str, ...]:
        """The labels of the criteria in the given order."""
        return tuple(dict.fromkeys(self.columns["criteria"].tolist()))

    def citations(self) -> Citations:
        """The BibTeX entries of the sources of all contenders and criteria, each once; see `jtik.citations`."""
        return Citations("\n\n".join(self.settings.get("citations", ())))

    def rows(self, **chosen: str) -> NDArray[np.intp]:
        """Indices of the rows with the values ``chosen``, such as ``rows(contender="hybrid", kind="reachable")``."""
        picked = np.ones(len(self), dtype=bool)
        for name, value in chosen.items():
            picked &= self.columns[name] == value
        return np.flatnonzero(picked)

    def summary(self, by: str | Sequence[str] | None = None) -> dict[str, list[Any]]:
        """The columns of `table` as lists by title, without pandas.

        Args:
            by: columns to group by, as of `table`.

        Raises:
            ArgumentError: for another column.
        """
        if by is None:
            by = ("contender", "criteria") if len(self.criteria) > 1 else ("contender",)
        return summary(self.columns, (by,) if isinstance(by, str) else by)

    def table(self, by: str | Sequence[str] | None = None) -> pandas.DataFrame:
        """Summary table with one row for each contender: success, and medians of iterations, time, H and so on.

        Success, compromise, errors, time per iteration, monotone and leakage include all cases; the other columns
        include solved cases only. "compromise" is the share of cases in which a strategy that is soft ended off target,
        at a stationary point of its weighted sum of task error and criterion: no success, but what it minimises.
        Clearance and limit margin are minima, leakage and drift maxima. Columns without values are left out.

        Args:
            by: other columns to group by: "contender", "criteria", "kind", "case", "status", or several of them.

        Raises:
            ArgumentError: for another column.
            MissingExtraError: without pandas.
        """
        return _pandas().DataFrame(self.summary(by))

    def frame(self) -> pandas.DataFrame:
        """All rows as a table.

        Raises:
            MissingExtraError: without pandas.
        """
        return _pandas().DataFrame(dict(self.columns))

    @property
    def notes(self) -> dict[str, int]:
        """Number of rows by contender and note, for the rows with a note."""
        counts: Counter[str] = Counter()
        own = (self.columns[name].tolist() for name in ("contender", "status", "note"))
        for contender, status, note in zip(*own, strict=True):
            if note.startswith((FALSE_SUCCESS, OLD_FALSE_SUCCESS)):
                counts[f"{contender}: {FALSE_SUCCESS}, but is off target by the independent check"] += 1
            elif note:
                new = status in FAILURES and not note.startswith(status)
                counts[f"{contender}: {status}: {note}" if new else f"{contender}: {note}"] += 1
        return dict(counts)

    def to_text(self, width: int | None = None) -> str:
        """The title, the summary table and the notes as text.

        Args:
            width: most characters of a line; None for no bound. Columns that do not fit are left out by the order in
                `jtik.study.summary.DROPPED_FIRST`, and named below the table.
        """
        table: Mapping[str, Sequence[Any]] = self.summary()
        dropped: list[str] = []
        if width is not None:
            table, dropped = tables.fitted(table, width, DROPPED_FIRST)
        notes = [f"  left out: {', '.join(dropped)}"] if dropped else []
        around = [[self._title()], [tables.text(table)], [*notes, *self._notes()]]
        if width is not None:
            around[::2] = [[_folded(line, width) for line in lines] for lines in around[::2]]
        return "\n".join(line for lines in around for line in lines)

    def to_markdown(self, by: str | Sequence[str] | None = None) -> str:
        """The summary table in Markdown, grouped ``by`` columns as in `table`."""
        return tables.markdown(self.summary(by))

    def to_csv(self, path: str | Path) -> None:
        """Write all rows to the file ``path`` without loss of precision. Raises OSError if it cannot be written.

        Text that a spreadsheet would take for a formula, such as a name ``=cmd``, begins with an apostrophe.
        """
        with Path(path).open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(self.columns)
            columns = [map(tables.spreadsheet_text, column.tolist()) for column in self.columns.values()]
            writer.writerows(zip(*columns, strict=True))

    def to_html(self, path: str | Path) -> None:
        """Write a self-contained report with tables, figures and settings to the file ``path``.

        Raises:
            MissingExtraError: without matplotlib.
            OSError: if it cannot be written.
        """
        from jtik.study.html import page

        Path(path).write_text(page(self), encoding="utf-8")

    def plot_convergence(self, **options: Any) -> Figure:
        """Draw the task error by iteration. ``options``: ``contenders``, ``criteria``, ``kind`` of the cases."""
        from jtik.study.figures.convergence import convergence

        return convergence(self, **options)

    def plot_profile(self, **options: Any) -> Figure:
        """Draw Dolan-More performance profiles.

        Args:
            options: ``measure``, "seconds" or "iterations"; ``contenders``, ``criteria``.
        """
        from jtik.study.figures.profile import profile

        return profile(self, **options)

    def plot_lyapunov(self, **options: Any) -> Figure:
        """Draw V by iteration for one case. ``options``: ``case``, ``contenders``, ``criteria``."""
        from jtik.study.figures.lyapunov import lyapunov

        return lyapunov(self, **options)

    def plot_criteria(self, **options: Any) -> Figure:
        """Draw H by iteration for one case, the regret of all. ``options``: ``case``, ``contenders``, ``criteria``."""
        from jtik.study.figures.criteria import criteria

        return criteria(self, **options)

    def plot_postures(self, **options: Any) -> Figure:
        """Draw the robot from start to answer for one case. ``options``: ``case``, ``contenders``, ``criteria``."""
        from jtik.study.figures.postures import posture_panels

        return posture_panels(self, **options)

    def plot_joints(self, **options: Any) -> Figure:
        """Draw joint positions by iteration for one case. ``options``: ``case``, ``contenders``, ``criteria``."""
        from jtik.study.figures.joints import joint_panels

        return joint_panels(self, **options)

    def animate(self, path: str | Path, **options: Any) -> None:
        """Write a GIF of one contender on one case.

        Args:
            path: the file, which ends in .gif.
            options: ``contender``, ``case`` and ``criteria``, by name.
        """
        from jtik.study.figures.animation import animation

        animation(self, path, **options)

    def save(self, path: str | Path) -> None:
        """Write the comparison to one ``.npz`` file ``path``, which `load` reads.

        Raises:
            ArgumentError: for another suffix.
            OSError: if it cannot be written.
        """
        from jtik.study.result_file import write

        write(self, path)

    @classmethod
    def load(cls, path: str | Path) -> Comparison:
        """Read a file ``path`` of `save`, or of ``jtik.compare(save=path)``.

        Raises:
            ArgumentError: for a file that holds no study.
            OSError: if it cannot be read.
        """
        from jtik.study.result_file import read

        return read(path)

    def __repr__(self) -> str:
        return self.to_text()

    def _repr_html_(self) -> str:
        notes = "".join(f"<li>{html.escape(note.strip())}</li>" for note in self._notes())
        return f"<p>{html.escape(self._title())}</p>{tables.markup(self.summary())}<ul>{notes}</ul>"

    def _title(self) -> str:
        kinds = ", ".join(f"{len(self.problems.of(kind))} {kind}" for kind in self.problems.kinds)
        state = "" if self.complete else "; incomplete"
        return f"Comparison of {len(self.contenders)} strategies on {self.robot.name!r}: {kinds}{state}"

    def _notes(self) -> list[str]:
        return [f"  {note} ({count} {'row' if count == 1 else 'rows'})" for note, count in self.notes.items()]


def assembled(plan: StudyPlan, results: Sequence[UnitResult], **known: Any) -> Comparison:
    """The comparison of the completed units of a plan, with rows ordered by criteria, contender and case.

    Args:
        plan: the study.
        results: the results of its units.
        known: the attributes that do not follow from these.
    """
    contender_index = {name: i for i, name in enumerate(plan.contenders)}
    criteria_index = {name: i for i, name in enumerate(plan.criteria)}
    case_index = {case.name: i for i, case in enumerate(plan.problems)}
    pairs = [pair for result in results for pair in zip(result.rows, result.answers, strict=True)]
    pairs.sort(
        key=lambda pair: (
            criteria_index[pair[0].criteria],
            contender_index[pair[0].contender],
            case_index[pair[0].case],
        )
    )
    rows = [row for row, _ in pairs]
    columns: dict[str, NDArray[Any]] = {}
    for name in COLUMNS:
        kind = str if name in TEXTS else bool if name == "success" else float
        columns[name] = np.array([getattr(row, name) for row in rows], dtype=kind)
    columns["regret"] = regret(columns)
    robot, tasks = plan.setting.reduced()
    return Comparison(
        columns=columns,
        answers=np.array([q for _, q in pairs]).reshape(len(pairs), robot.nq),
        traces={key: trace for result in results for key, trace in result.traces.items()},
        paths={key: path for result in results for key, path in result.paths.items()},
        robot=robot,
        tasks=tasks.tasks,
        problems=plan.problems,
        **known,
    )


def regret(columns: Mapping[str, NDArray[Any]]) -> Array:
    """H minus the smallest H of the contenders that solved the case with the same criteria; NaN if not solved."""
    solved, H = columns["success"], columns["H"]
    keys = list(zip(columns["criteria"].tolist(), columns["case"].tolist(), strict=True))
    smallest: dict[tuple[str, str], float] = {}
    for key, value, good in zip(keys, H.tolist(), solved.tolist(), strict=True):
        if good and not np.isnan(value):
            smallest[key] = min(smallest.get(key, np.inf), value)
    best = np.array([smallest.get(key, np.nan) for key in keys], dtype=float).reshape(len(keys))
    difference: Array = np.where(solved, H - best, np.nan)
    return difference


def _folded(line: str, width: int) -> str:
    """A line over several lines, the others indented."""
    return textwrap.fill(line, max(width, 20), subsequent_indent="    ", drop_whitespace=True)


def _pandas() -> Any:
    try:
        import pandas
    except ImportError as error:
        raise MissingExtraError("pandas", "study", "a table") from error
    return pandas
