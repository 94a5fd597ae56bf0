"""``jtik compare``: compare strategies on the same problems; prints a table and writes a report as one HTML file."""

from __future__ import annotations

import argparse
import json
import shutil
import sys
from collections.abc import Iterable, Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager
from typing import Any

import jtik
from jtik.cli import own_criteria
from jtik.cli.checks import InputError, check_folder, check_suffix
from jtik.cli.document import DocumentSetup, read_setup
from jtik.cli.output import PICTURES, json_value, require_pictures, shows_progress, write_all
from jtik.cli.problem_options import add_problem_options, problem_document
from jtik.problems import ProblemSet
from jtik.problems.collection import named
from jtik.registry import strategies, strategy_of
from jtik.study import peers
from jtik.study.comparison import Comparison
from jtik.study.strategies import PEER

INTERRUPTED = 130
"""Exit code after Ctrl-C. The report has what was computed before."""

DEFAULT_STRATEGIES = ("hybrid", "newton", "transpose", "damped")
"""The strategies that are compared by default."""


def add_arguments(commands: Any) -> None:
    """Add the command ``compare`` to argparse's subparsers."""
    command = commands.add_parser(
        "compare",
        help="compare strategies on the same problems",
        description="Compare strategies on the same problems, from the same starts, to the same tolerances.",
        epilog="Exit code: 0 done, 1 a file could not be written, 2 wrong input, 130 interrupted. Lengths in m, angles "
        "in rad. The robot is planar:10 and the task a position of its tip by default. The table leaves out columns "
        "that do not fit; --markdown, --json and --csv have all of them.",
    )
    add_problem_options(command, kind="position")
    what = (
        f"names that `jtik list` shows, or all; peer:NAME for another library (default: {' '.join(DEFAULT_STRATEGIES)})"
    )
    command.add_argument(
        "--strategies", "--strategy", nargs="+", metavar="NAME", default=list(DEFAULT_STRATEGIES), help=what
    )
    command.add_argument(
        "--problems",
        nargs="+",
        metavar="KIND[:COUNT]",
        default=["reachable"],
        help="reachable, near_singular, boundary, unreachable, near_limits, circle, line, lissajous; or named:NAME for "
        "a problem set with its own robot, task and known answers (default: reachable)",
    )
    command.add_argument("--count", type=int, default=50, help="number of problems of each kind (default: %(default)s)")
    command.add_argument("--seed", type=int, default=0, help="seed of the problems and restarts (default: %(default)s)")
    command.add_argument(
        "--restarts", type=int, default=0, help="number of further starts to try (default: %(default)s)"
    )
    command.add_argument("--until", choices=("reached", "stationary"), default="reached", help="(default: %(default)s)")
    command.add_argument("--max-iterations", type=int, default=1000, metavar="N", help="(default: %(default)s)")
    command.add_argument("--position-tolerance", type=float, default=1e-6, metavar="METRES")
    command.add_argument("--orientation-tolerance", type=float, default=1e-6, metavar="RADIANS")
    command.add_argument("--no-limits", dest="limits", action="store_false", help="ignore joint limits")
    command.add_argument("--compiled", action="store_true", help="steps as generated C, where there is a compiler")
    command.add_argument("--repeats", type=int, default=3, help="timed rounds (default: %(default)s)")
    command.add_argument("--jobs", type=int, default=1, metavar="N", help="number of processes (default: %(default)s)")
    command.add_argument("--save", metavar="FILE.npz", help="save the study here while it runs, and resume from it")
    command.add_argument("--csv", metavar="FILE", help="write every row to this file")
    command.add_argument("--markdown", action="store_true", help="print the table in Markdown")
    command.add_argument("--json", action="store_true", help="print the table and the settings as JSON")
    command.add_argument("--plot", metavar="FILE", help="draw the performance profiles: .png, .svg or .pdf")
    command.add_argument(
        "--out", metavar="FILE.html", default="jtik-compare.html", help="report (default: %(default)s)"
    )
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Compare, print the table, write the report."""
    check_folder(arguments.out, arguments.csv, arguments.save, arguments.plot)
    check_suffix("--plot", arguments.plot, PICTURES)
    require_pictures()  # for the report
    if arguments.jobs < 1:
        raise InputError(f"--jobs {arguments.jobs}: accepted: a positive integer")
    contenders = _contenders(arguments.strategies)
    setup, problems = _setup_and_problems(arguments)
    with _executor(arguments.jobs, arguments.criterion or ()) as executor:
        found = jtik.compare(
            setup.robot,
            setup.tasks,
            strategies=contenders,
            criteria=setup.criteria if setup.criteria.terms else None,
            problems=problems,
            count=arguments.count,
            seed=arguments.seed,
            restarts=arguments.restarts,
            until=arguments.until,
            max_iterations=arguments.max_iterations,
            position_tolerance=arguments.position_tolerance,
            orientation_tolerance=arguments.orientation_tolerance,
            limits=arguments.limits,
            compiled=arguments.compiled,
            repeats=arguments.repeats,
            executor=executor,
            save=arguments.save,
            progress=shows_progress(),
        )
    _print(found, arguments)
    written = write_all(
        [
            (arguments.csv, found.to_csv),
            (arguments.plot, lambda path: found.plot_profile().savefig(path)),
            (arguments.out, found.to_html),
        ]
    )
    if written:
        print(f"written: {arguments.out}", file=sys.stderr if arguments.json else sys.stdout)
    return INTERRUPTED if not found.complete else 0 if written else 1


def _print(found: Comparison, arguments: argparse.Namespace) -> None:
    """Print the table, in the width of the terminal; 80 characters where it goes elsewhere."""
    if arguments.json:
        table = found.summary()
        rows = [dict(zip(table, row, strict=True)) for row in zip(*table.values(), strict=True)]
        document = {"complete": found.complete, "table": rows, "notes": found.notes, "settings": found.settings}
        print(json.dumps(json_value({**document, "machine": found.machine}), indent=1))
    elif arguments.markdown:
        print(found.to_markdown())
    else:
        print(found.to_text(shutil.get_terminal_size().columns))


def _contenders(names: list[str]) -> list[str]:
    """The names of the contenders. Raises UnknownNameError or ArgumentError for one that does not exist."""
    if names == ["all"]:
        return list(strategies)
    for name in names:
        if name.startswith(PEER):
            peers.named(name.removeprefix(PEER))
        else:
            strategy_of(name)
    return names


def _setup_and_problems(arguments: argparse.Namespace) -> tuple[DocumentSetup, ProblemSet | dict[str, int]]:
    """Robot, tasks and criteria, and the problems."""
    words: list[str] = arguments.problems
    collections = [word.partition(":")[2] for word in words if word.startswith("named:")]
    document = problem_document(arguments)
    if collections:
        if len(words) > 1 or document.get("robot") or document.get("task"):
            raise InputError("--problems named:NAME: accepted: alone; it has its own robot and task")
        entry = named(collections[0])
        own = read_setup({**document, "robot": "planar:1"}).criteria
        criteria = own if own.terms else jtik.CriterionSum(()) + entry.criteria if entry.criteria else own
        return DocumentSetup(entry.robot, _as_list(entry.task), criteria), entry.problems
    document.setdefault("robot", "planar:10")
    return read_setup(document), dict(_counted(word, arguments.count) for word in words)


def _as_list(task: Any) -> list[jtik.Task]:
    return [task] if isinstance(task, jtik.Task) else list(task)


def _counted(word: str, count: int) -> tuple[str, int]:
    kind, colon, number = word.partition(":")
    if colon and not (number.isdecimal() and len(number) < 10):
        raise InputError(f"--problems {word}: accepted: KIND or KIND:COUNT")
    return kind, int(number) if colon else count


@contextmanager
def _executor(jobs: int, criteria: Iterable[str]) -> Iterator[Executor | None]:
    """An executor of several processes, which know the user's own criteria; None for one job."""
    if jobs == 1:
        yield None
        return
    files = [name.rpartition(":")[0] for name in criteria if own_criteria.is_own(name)]
    with ProcessPoolExecutor(jobs, initializer=own_criteria.load_modules, initargs=(files,)) as pool:
        yield pool
