"""The result of a study: a row a contender and case, summed up as tables, kept in files."""

from __future__ import annotations

import csv
import html
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from jtik.errors import MissingExtraError
from jtik.problems import ProblemSet
from jtik.result.solution import Trace
from jtik.robot import Robot
from jtik.study import display
from jtik.study.rows import CLAIMS, COLUMNS, FAILURES, TEXTS
from jtik.study.summary import summary
from jtik.task import Task
from jtik.types import Array

if TYPE_CHECKING:
    import pandas

    from jtik.plotting.planar import Figure
    from jtik.study.units import Block, Key, Plan


@dataclass(frozen=True, eq=False, repr=False)
class Comparison:
    """What `jtik.compare` found. Its rows are those of `jtik.study.rows.Row`, which says what every column is.

    Attributes:
        columns: an array a column, by name; a row is one contender with one set of criteria on one case.
        answers: the configuration each row ends at, (rows, nq), NaN where there is none.
        traces: iterations by (contender, criteria, case), for the first cases of each kind.
        paths: postures (k, nq) along paths, by the same key, for those cases.
        robot: the robot that q belongs to: without the joints that took no part.
        tasks: what it had to do, one task or several; empty where a file could not keep a task that is not jtik's own.
        problems: the cases.
        settings: options of the study, as words and numbers.
        machine: what it ran on: platform and versions.
        complete: whether every unit of the study is in it.
        fingerprint: the same for equal studies.
    """

    columns: Mapping[str, NDArray[Any]]
    answers: Array
    traces: Mapping[Key, Trace]
    paths: Mapping[Key, Array]
    robot: Robot
    tasks: tuple[Task, ...]
    problems: ProblemSet
    settings: Mapping[str, Any] = field(default_factory=dict)
    machine: Mapping[str, str] = field(default_factory=dict)
    complete: bool = True
    fingerprint: str = ""

    def __len__(self) -> int:
        return len(self.answers)

    @property
    def task(self) -> Task | tuple[Task, ...]:
        """The task, or the tasks where there are several."""
        return self.tasks[0] if len(self.tasks) == 1 else self.tasks

    @property
    def contenders(self) -> tuple[str, ...]:
        """Who took part, in the order they were named."""
        return tuple(dict.fromkeys(self.columns["contender"].tolist()))

    @property
    def criteria(self) -> tuple[str, ...]:
        """The labels of the criteria, in the order they were named."""
        return tuple(dict.fromkeys(self.columns["criteria"].tolist()))

    def rows(self, **chosen: str) -> NDArray[np.intp]:
        """Places of the rows with these entries, such as ``rows(contender="hybrid", kind="reachable")``."""
        picked = np.ones(len(self), dtype=bool)
        for name, value in chosen.items():
            picked &= self.columns[name] == value
        return np.flatnonzero(picked)

    def summary(self, by: str | Sequence[str] | None = None) -> dict[str, list[Any]]:
        """The figures of `table`, as lists by title, without pandas."""
        if by is None:
            by = ("contender", "criteria") if len(self.criteria) > 1 else ("contender",)
        return summary(self.columns, (by,) if isinstance(by, str) else by)

    def table(self, by: str | Sequence[str] | None = None) -> pandas.DataFrame:
        """A line a contender: success and, of the solved cases, medians of iterations, time, H, and so on.

        Errors, monotony and leakage are of all cases, clearance and limit margin the least, leakage and drift the
        largest. Figures that nothing has are left out.

        Args:
            by: what to group by instead: "contender", "criteria", "kind", "case", "status", or several of them.

        Raises:
            MissingExtraError: without pandas.
        """
        return _pandas().DataFrame(self.summary(by))

    def frame(self) -> pandas.DataFrame:
        """All rows.

        Raises:
            MissingExtraError: without pandas.
        """
        return _pandas().DataFrame(dict(self.columns))

    @property
    def notes(self) -> dict[str, int]:
        """What went wrong, each sentence with the contender it is about, and in how many rows."""
        told: Counter[str] = Counter()
        own = (self.columns[name].tolist() for name in ("contender", "status", "note"))
        for contender, status, note in zip(*own, strict=True):
            if note.startswith(CLAIMS):
                told[f"{contender}: {CLAIMS} where it is not"] += 1
            elif note:
                new = status in FAILURES and not note.startswith(status)
                told[f"{contender}: {status}: {note}" if new else f"{contender}: {note}"] += 1
        return dict(told)

    def to_markdown(self, by: str | Sequence[str] | None = None) -> str:
        """The table in Markdown."""
        return display.markdown(self.summary(by))

    def to_csv(self, path: str | Path) -> None:
        """Write all rows, numbers to the last bit, to a file. Raises OSError when it cannot be written."""
        with Path(path).open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(self.columns)
            writer.writerows(zip(*[column.tolist() for column in self.columns.values()], strict=True))

    def to_html(self, path: str | Path) -> None:
        """Write a report that needs no other file: tables, figures, settings.

        Raises:
            MissingExtraError: without matplotlib.
            OSError: when it cannot be written.
        """
        from jtik.study.html import page

        Path(path).write_text(page(self), encoding="utf-8")

    def plot_convergence(self, **options: Any) -> Figure:
        """`jtik.study.figures.convergence`: error by iteration. Options: contenders, criteria, kind."""
        from jtik.study.figures.convergence import convergence

        return convergence(self, **options)

    def plot_profile(self, **options: Any) -> Figure:
        """`jtik.study.figures.profile`: Dolan-More profiles. Options: measure ("seconds", "iterations"), contenders,
        criteria."""
        from jtik.study.figures.profile import profile

        return profile(self, **options)

    def plot_lyapunov(self, **options: Any) -> Figure:
        """`jtik.study.figures.lyapunov`: V of one case. Options: case, contenders, criteria."""
        from jtik.study.figures.lyapunov import lyapunov

        return lyapunov(self, **options)

    def plot_criteria(self, **options: Any) -> Figure:
        """`jtik.study.figures.criteria`: H of one case, regret of all. Options: case, contenders, criteria."""
        from jtik.study.figures.criteria import criteria

        return criteria(self, **options)

    def plot_postures(self, **options: Any) -> Figure:
        """`jtik.study.figures.postures`: the arm of one case. Options: case, contenders, criteria."""
        from jtik.study.figures.postures import posture_panels

        return posture_panels(self, **options)

    def plot_joints(self, **options: Any) -> Figure:
        """`jtik.study.figures.joints`: q of one case. Options: case, contenders, criteria."""
        from jtik.study.figures.joints import joint_panels

        return joint_panels(self, **options)

    def animate(self, path: str | Path, **options: Any) -> None:
        """`jtik.study.figures.animation`: one contender on one case as a GIF. Options: contender, case, criteria."""
        from jtik.study.figures.animation import animation

        animation(self, path, **options)

    def save(self, path: str | Path) -> None:
        """Write all of it to one file, a ``.npz``; `load` reads it back.

        Raises:
            ArgumentError: for another suffix.
            OSError: when it cannot be written.
        """
        from jtik.study.store import write

        write(self, path)

    @classmethod
    def load(cls, path: str | Path) -> Comparison:
        """Read what `save` wrote, or what ``jtik.compare(save=path)`` did.

        Raises:
            ArgumentError: for a file that is none.
            OSError: when it cannot be read.
        """
        from jtik.study.store import read

        return read(path)

    def __repr__(self) -> str:
        return "\n".join([self._title(), display.text(self.summary()), *self._told()])

    def _repr_html_(self) -> str:
        notes = "".join(f"<li>{html.escape(note.strip())}</li>" for note in self._told())
        return f"<p>{html.escape(self._title())}</p>{display.markup(self.summary())}<ul>{notes}</ul>"

    def _title(self) -> str:
        kinds = ", ".join(f"{len(self.problems.of(kind))} {kind}" for kind in self.problems.kinds)
        state = "" if self.complete else "; not complete"
        return f"Comparison of {len(self.contenders)} strategies on {self.robot.name!r}: {kinds}{state}"

    def _told(self) -> list[str]:
        return [f"  {note} ({count} {'row' if count == 1 else 'rows'})" for note, count in self.notes.items()]


def assembled(plan: Plan, blocks: Sequence[Block], **known: Any) -> Comparison:
    """The comparison of what has been done of a plan, its rows by criteria, contender and case.

    Args:
        plan: the study.
        blocks: what its units found.
        known: the attributes that do not follow from these.
    """
    who = {name: i for i, name in enumerate(plan.contenders)}
    label = {name: i for i, name in enumerate(plan.criteria)}
    place = {case.name: i for i, case in enumerate(plan.problems)}
    pairs = [pair for block in blocks for pair in zip(block.rows, block.answers, strict=True)]
    pairs.sort(key=lambda pair: (label[pair[0].criteria], who[pair[0].contender], place[pair[0].case]))
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
        traces={key: trace for block in blocks for key, trace in block.traces.items()},
        paths={key: path for block in blocks for key, path in block.paths.items()},
        robot=robot,
        tasks=tasks.tasks,
        problems=plan.problems,
        **known,
    )


def regret(columns: Mapping[str, NDArray[Any]]) -> Array:
    """H less the least H of those who solved the same case with the same criteria; NaN for who did not."""
    solved, H = columns["success"], columns["H"]
    keys = list(zip(columns["criteria"].tolist(), columns["case"].tolist(), strict=True))
    least: dict[tuple[str, str], float] = {}
    for key, value, good in zip(keys, H.tolist(), solved.tolist(), strict=True):
        if good and not np.isnan(value):
            least[key] = min(least.get(key, np.inf), value)
    best = np.array([least.get(key, np.nan) for key in keys], dtype=float).reshape(len(keys))
    difference: Array = np.where(solved, H - best, np.nan)
    return difference


def _pandas() -> Any:
    try:
        import pandas
    except ImportError as error:
        raise MissingExtraError("pandas", "study", "a table") from error
    return pandas
