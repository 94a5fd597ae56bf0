"""Wall time of `jtik.compare`, and comparison of its times with those of the same solves outside a study.

    python benchmarks/study.py [--cases 200] [--processes 2] [--compiled] [--cpu]

Twelve strategies solve problems of the ten-link arm and of the Panda, first on a process pool for the wall time. Then a
smaller study in this process alternates with loops of ``ik.solve`` calls of each strategy on the same problems. The
script prints ratios of sums over the cases: of the median over the rounds, which a study reports, and of the minimum,
which other load disturbs less. With --cpu both measure the processor time of their thread, which other programs hardly
influence. Nothing is asserted.
"""

from __future__ import annotations

import argparse
import statistics
import time
from concurrent.futures import ProcessPoolExecutor

import numpy as np

import jtik
from jtik.problems import ProblemSet, reachable
from jtik_formulations import JointCentering

STRATEGIES = (
    "transpose",
    "transpose_bb",
    "damped",
    "damped_constant",
    "nakamura",
    "sugihara",
    "selectively_damped",
    "newton",
    "hybrid",
    "jparse",
    "task_priority",
    "weighted_least_norm",
)

TURNS = 4
"""Number of alternations of study and loop; the shorter time of each counts."""

ARMS = {
    "ten links": (jtik.Robot.planar(10), jtik.FrameTask("tip")),
    "panda": (jtik.Robot.builtin("panda"), jtik.FrameTask("tip", "pose")),
}


def solve_times(
    ik: jtik.InverseKinematics, problems: ProblemSet, rounds: int, options: dict[str, object]
) -> list[list[float]]:
    """Times of the solves alone, for each case and round [s]."""
    times: list[list[float]] = [[] for _ in problems]
    for _ in range(rounds):
        ik.solve(problems[0].target, q0=problems[0].q0, **options)
        for case, seconds in zip(problems, times, strict=True):
            target, q0 = case.target, case.q0
            begin = time.perf_counter()
            ik.solve(target, q0=q0, **options)
            seconds.append(time.perf_counter() - begin)
    return times


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=200)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument(
        "--alone", type=int, default=40, help="cases to time outside the study as well (default %(default)s)"
    )
    parser.add_argument("--compiled", action="store_true")
    parser.add_argument("--cpu", action="store_true")
    arguments = parser.parse_args()
    clock = time.perf_counter
    options = {"max_iterations": 200, "until": "reached", "restarts": 0}
    for name, (robot, task) in ARMS.items():
        study = {"strategies": STRATEGIES, "criteria": JointCentering(), "compiled": arguments.compiled, **options}
        problems = reachable(robot, task, arguments.cases)
        with ProcessPoolExecutor(arguments.processes) as pool:
            begin = time.perf_counter()
            result = jtik.compare(robot, task, problems=problems, executor=pool, **study)
            wall = time.perf_counter() - begin
        print(f"\n{name}: {len(result)} rows on {arguments.processes} processes in {wall:.1f} s")
        print(result)

        if arguments.cpu:
            time.perf_counter = time.thread_time  # for the study and the loop
        some, rounds = problems[: arguments.alone], 5
        build = {"criteria": study["criteria"], "compiled": arguments.compiled}
        solvers = {name: jtik.InverseKinematics(robot, task, strategy=name, **build) for name in STRATEGIES}
        studied: dict[str, list[np.ndarray]] = {name: [] for name in STRATEGIES}
        looped: dict[str, list[np.ndarray]] = {name: [] for name in STRATEGIES}
        for _ in range(TURNS):
            result = jtik.compare(robot, task, problems=some, repeats=rounds, **study)
            for strategy, ik in solvers.items():
                rows, alone = result.rows(contender=strategy), solve_times(ik, some, rounds, options)
                studied[strategy].append(np.array([result.columns[name][rows] for name in ("seconds", "seconds_low")]))
                looped[strategy].append(np.array([[statistics.median(each), min(each)] for each in alone]).T)
        time.perf_counter = clock
        print(f"\n{'':22}   study    alone     ratio   ratio of minima")
        for strategy in STRATEGIES:
            (study_median, study_low), (median, low) = (
                np.min(studied[strategy], axis=0),
                np.min(looped[strategy], axis=0),
            )
            sums = f"{1e3 * study_median.sum():7.1f}  {1e3 * median.sum():7.1f} ms"
            ratios = f"{study_median.sum() / median.sum():6.2f}  {study_low.sum() / low.sum():6.2f}"
            print(f"{strategy:22} {sums}  {ratios}", flush=True)


if __name__ == "__main__":
    main()
