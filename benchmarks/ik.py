"""Global inverse kinematics by the protocol of TRAC-IK: seven arms, jtik and other solvers.

Targets are poses of configurations uniform within the limits. Every solver starts at the middle of the limits and may
restart. An answer counts if, according to Pinocchio, it is within the limits and both errors are below the tolerance.
All solvers run in one process, in rounds. In each round every solver solves the same block of targets, in random order,
so that slow periods of the machine and the state of the caches affect all rows alike.

    python benchmarks/ik.py [--targets 1000] [--arms panda ur5] [--solvers jtik rtb optik] [--tolerance 1e-5 1e-5]

The other solvers are installed by

    python -m pip install roboticstoolbox-python optik-py mink pin pin-pink example-robot-data rich
"""

from __future__ import annotations

import argparse
import gc
import importlib
import json
import os
import platform
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))

from ik_arms import FILE_SLACK, SOURCES, Arm, check, read_arm
from ik_solvers import CLOSED_FORM, OURS, SLOW, SOLVERS, Accuracy, NotBuiltError, PreparedSolver
from packages import versions

Array = np.ndarray
WARM_UP = 20
"""Additional targets that every solver solves first, without counting."""
MIN_SOLVED = 99.0
"""Share of targets that a peer must solve for its time to be compared with [%]."""
PACKAGES = ("numpy", "casadi", "roboticstoolbox-python", "optik-py", "mink", "daqp", "pin-pink", "pin", "placo", "ssik")


@dataclass
class Tally:
    """Times and answers of a solver on an arm.

    Attributes:
        times: time of each target [s].
        targets: number of each target.
        answers: answer for each target, or None.
    """

    times: list[float] = field(default_factory=list)
    targets: list[int] = field(default_factory=list)
    answers: list[Array | None] = field(default_factory=list)


@dataclass(frozen=True)
class Row:
    """Figures of a solver on an arm. Times include failed solves.

    Attributes:
        arm: name of the arm.
        solver: name of the solver.
        targets: number of targets.
        solved: share of targets with an answer that the check accepts [%].
        wrong: number of answers that the solver reports as a success and the check rejects.
        unanswered: number of targets for which it returns no solution.
        median: median time [us].
        mean: mean time [us].
        p90: ninetieth percentile of the time [us].
        median_ratio: ratio to the smallest median of a peer.
        mean_ratio: ratio to the smallest mean of a peer.
        note: why there are no figures.
    """

    arm: str
    solver: str
    targets: int = 0
    solved: float = 0.0
    wrong: int = 0
    unanswered: int = 0
    median: float = 0.0
    mean: float = 0.0
    p90: float = 0.0
    median_ratio: float | None = None
    mean_ratio: float | None = None
    note: str = ""


def prepared(arm: Arm, names: Sequence[str], accuracy: Accuracy) -> tuple[dict[str, PreparedSolver], dict[str, str]]:
    """Solvers built for the arm, and the reasons why others are missing."""
    solvers, missing = {}, {}
    for name in names:
        try:
            solvers[name] = SOLVERS[name](arm, accuracy)
        except ImportError as error:
            missing[name] = f"not installed: {error.name or error}"
        except NotBuiltError as error:
            missing[name] = str(error)
    return solvers, missing


def run_block(solver: PreparedSolver, tally: Tally, block: Sequence[int], targets: Sequence[Array]) -> None:
    """Solve a block of targets and record times and answers. The targets of a batch get its mean time."""
    given = [solver.convert(targets[i]) for i in block]
    clock = time.perf_counter
    if solver.batch:
        begin = clock()
        answers = list(solver.batch(given))
        times = [(clock() - begin) / len(block)] * len(block)
    else:
        solve, answers, times = solver.solve, [], []
        for one in given:
            begin = clock()
            answer = solve(one)
            times.append(clock() - begin)
            answers.append(answer)
    tally.times += times
    tally.answers += [None if each is None else np.array(each) for each in answers]
    tally.targets += block


def run_rounds(
    arm: Arm,
    solvers: dict[str, PreparedSolver],
    targets: Sequence[Array],
    *,
    block: int,
    thinned: int,
    watch: Callable[[Sequence[Any], str], Iterator[Any]],
) -> dict[str, Tally]:
    """Run all solvers on all targets in rounds; slow solvers take every ``thinned``-th target."""
    tallies = {name: Tally() for name in solvers}
    names, generator = list(solvers), np.random.default_rng(0)
    for solver in solvers.values():
        run_block(solver, Tally(), range(WARM_UP), targets[:WARM_UP])
    counted = targets[WARM_UP:]
    starts = range(0, len(counted), block)
    gc.collect()
    gc.freeze()  # repeated collection of the libraries' objects would take longer than the solves
    gc.disable()
    try:
        for start in watch(starts, arm.name):
            chosen = list(range(start, min(start + block, len(counted))))
            for name in generator.permutation(names):
                mine = [i for i in chosen if i % thinned == 0] if name in SLOW else chosen
                if mine:
                    run_block(solvers[name], tallies[name], mine, counted)
            gc.collect()
    finally:
        gc.enable()
        gc.unfreeze()
    return tallies


def row(arm: Arm, name: str, tally: Tally, targets: Sequence[Array], accuracy: Accuracy) -> Row:
    """The figures of a solver, with a check of every answer."""
    solved = wrong = unanswered = 0
    for i, answer in zip(tally.targets, tally.answers, strict=True):
        if answer is None:
            unanswered += 1
            continue
        result = check(arm, targets[WARM_UP + i], answer)
        accepted = result.within and (
            result.position <= accuracy.position + FILE_SLACK
            and result.orientation <= accuracy.orientation + FILE_SLACK
        )
        solved += accepted
        wrong += not accepted
    times = 1e6 * np.array(tally.times)
    median, p90 = np.percentile(times, [50, 90])
    return Row(
        arm=arm.name,
        solver=name,
        targets=len(times),
        solved=100 * solved / len(times),
        wrong=wrong,
        unanswered=unanswered,
        median=float(median),
        mean=float(times.mean()),
        p90=float(p90),
    )


def with_ratios(rows: list[Row]) -> list[Row]:
    """The rows with their ratios to the smallest median and mean of the peers that solve enough targets."""
    excluded = (*OURS, *CLOSED_FORM)
    compared = [each for each in rows if each.solver not in excluded and not each.note and each.solved >= MIN_SOLVED]
    if not compared:
        return rows
    median, mean = min(each.median for each in compared), min(each.mean for each in compared)
    return [
        each if each.note else replace(each, median_ratio=each.median / median, mean_ratio=each.mean / mean)
        for each in rows
    ]


def show(rows: list[Row], out: Any) -> None:
    """Print the table of an arm."""
    head = "targets  solved [%]  wrong  no answer  median [us]  mean [us]  90 % [us]  x best median  x best mean"
    print(f"\n{rows[0].arm:14} {head}", file=out)
    for each in rows:
        figures = (
            f"{each.targets:7}  {each.solved:10.2f}  {each.wrong:5}  {each.unanswered:9}"
            f"  {each.median:11.1f}  {each.mean:9.1f}  {each.p90:9.1f}"
        )
        if each.median_ratio is not None and each.mean_ratio is not None:
            figures += f"  {each.median_ratio:13.2f}  {each.mean_ratio:11.2f}"
        print(f"{each.solver:14} {each.note or figures}", file=out)


def summary(rows: list[Row], out: Any) -> None:
    """Print a Markdown table of all arms: median / mean, and the share of solved targets if below 100 %."""
    arms, solvers = list(dict.fromkeys(each.arm for each in rows)), list(dict.fromkeys(each.solver for each in rows))
    cells = {}
    for each in rows:
        cell = f"{each.median:.0f} / {each.mean:.0f}"
        if each.solved < 100:
            cell += f", {each.solved:.2f} %"
        cells[each.solver, each.arm] = "" if each.note else cell
    print(f"\n| median / mean [us] | {' | '.join(arms)} |\n| --- |{' --- |' * len(arms)}", file=out)
    for solver in solvers:
        print(f"| {solver} | {' | '.join(cells[solver, arm] for arm in arms)} |", file=out)


def watcher() -> Callable[[Sequence[Any], str], Iterator[Any]]:
    """A progress bar if rich is installed and the output is a terminal."""
    try:
        progress = importlib.import_module("rich.progress")
        console = importlib.import_module("rich.console").Console(stderr=True)
    except ImportError:
        return lambda items, label: iter(items)
    if not console.is_terminal:
        return lambda items, label: iter(items)
    return lambda items, label: iter(progress.track(items, description=label, console=console))


def parsed() -> argparse.Namespace:
    """Parsed command line."""
    parser = argparse.ArgumentParser(description="Global inverse kinematics by the protocol of TRAC-IK.")
    parser.add_argument("--targets", type=int, default=1000, help="targets for each arm (default %(default)s)")
    parser.add_argument(
        "--slow-targets", type=int, default=100, help=f"targets for {', '.join(SLOW)} (default %(default)s)"
    )
    parser.add_argument("--block", type=int, default=50, help="consecutive targets of a solver (default %(default)s)")
    parser.add_argument("--arms", nargs="+", choices=list(SOURCES), default=list(SOURCES), help="arms")
    parser.add_argument("--solvers", nargs="+", choices=list(SOLVERS), default=list(SOLVERS), help="solvers")
    parser.add_argument(
        "--tolerance",
        nargs=2,
        type=float,
        default=[1e-5, 1e-5],
        metavar=("POSITION", "ORIENTATION"),
        help="norms of the errors to reach [m] [rad] (default 1e-5 1e-5)",
    )
    parser.add_argument("--seed", type=int, default=0, help="seed of the targets (default %(default)s)")
    parser.add_argument("--json", metavar="FILE", help="also write the figures to FILE, '-' for standard output")
    arguments = parser.parse_args()
    if min(arguments.targets, arguments.slow_targets, arguments.block) < 1:
        parser.error("--targets, --slow-targets and --block must be at least 1")
    return arguments


def main() -> None:
    """Measure, print, and optionally write the figures."""
    arguments = parsed()
    accuracy = Accuracy(*arguments.tolerance)
    thinned = -(-arguments.targets // arguments.slow_targets)
    out = sys.stderr if arguments.json == "-" else sys.stdout
    watch = watcher()
    rows: list[Row] = []
    for name in arguments.arms:
        try:
            arm = read_arm(name)
        except (ImportError, FileNotFoundError) as error:
            print(f"\n{name}: no description: {error}", file=out)
            continue
        generator = np.random.default_rng(arguments.seed)
        targets = [arm.pose(arm.draw(generator)) for _ in range(WARM_UP + arguments.targets)]
        solvers, missing = prepared(arm, arguments.solvers, accuracy)
        tallies = run_rounds(arm, solvers, targets, block=arguments.block, thinned=thinned, watch=watch)
        table = [
            row(arm, each, tallies[each], targets, accuracy)
            if each in tallies
            else Row(arm=name, solver=each, note=missing[each])
            for each in arguments.solvers
        ]
        table = with_ratios(table)
        show(table, out)
        rows += table
    if rows:
        summary(rows, out)
    if arguments.json:
        record = {
            "machine": f"{platform.machine()}, {platform.system()}, {os.cpu_count()} cores",
            "python": platform.python_version(),
            "versions": versions(PACKAGES),
            "tolerance": arguments.tolerance,
            "block": arguments.block,
            "seed": arguments.seed,
            "unit": "us",
            "rows": [asdict(each) for each in rows],
        }
        text = json.dumps(record, indent=2)
        if arguments.json == "-":
            print(text)
        else:
            Path(arguments.json).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
