"""Two questions about `jtik.compare`: how long does a study take, and are its times those of a solve by itself?

    python benchmarks/study.py [--cases 200] [--processes 2] [--compiled] [--cpu]

Twelve strategies on the ten-link arm and on the Panda, once on a process pool for the wall time. Then a smaller study
in this process, taking turns with loops of plain ``ik.solve`` calls of each strategy over the same problems, timed from
outside. Printed are ratios of sums over the cases: of the median of the rounds, which is what a study reports, and of
the least, which a busy machine disturbs less; with --cpu both read the processor's time of their thread instead, which
other programs hardly touch. Nothing is asserted.
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
"""How often study and loop take turns; the better turn of each counts."""

ARMS = {
    "ten links": (jtik.Robot.planar(10), jtik.FrameTask("tip")),
    "panda": (jtik.Robot.builtin("panda"), jtik.FrameTask("tip", "pose")),
}


def alone(
    ik: jtik.InverseKinematics, problems: ProblemSet, rounds: int, options: dict[str, object]
) -> list[list[float]]:
    """Times of each case in each round, of nothing but the solves [s]."""
    times: list[list[float]] = [[] for _ in problems]
    for _ in range(rounds):
        ik.solve(problems[0].target, q0=problems[0].q0, **options)
        for case, own in zip(problems, times, strict=True):
            target, q0 = case.target, case.q0
            begin = time.perf_counter()
            ik.solve(target, q0=q0, **options)
            own.append(time.perf_counter() - begin)
    return times


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=200)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--alone", type=int, default=40, help="cases to time alone, too (default %(default)s)")
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
            time.perf_counter = time.thread_time  # of study and loop alike
        some, rounds = problems[: arguments.alone], 5
        build = {"criteria": study["criteria"], "compiled": arguments.compiled}
        solvers = {law: jtik.InverseKinematics(robot, task, strategy=law, **build) for law in STRATEGIES}
        studied: dict[str, list[np.ndarray]] = {law: [] for law in STRATEGIES}
        looped: dict[str, list[np.ndarray]] = {law: [] for law in STRATEGIES}
        for _ in range(TURNS):
            result = jtik.compare(robot, task, problems=some, repeats=rounds, **study)
            for law, ik in solvers.items():
                rows, own = result.rows(contender=law), alone(ik, some, rounds, options)
                studied[law].append(np.array([result.columns[name][rows] for name in ("seconds", "seconds_low")]))
                looped[law].append(np.array([[statistics.median(each), min(each)] for each in own]).T)
        time.perf_counter = clock
        print(f"\n{'':22}   study    alone     ratio   of the least")
        for law in STRATEGIES:
            (study_median, study_low), (median, low) = np.min(studied[law], axis=0), np.min(looped[law], axis=0)
            sums = f"{1e3 * study_median.sum():7.1f}  {1e3 * median.sum():7.1f} ms"
            ratios = f"{study_median.sum() / median.sum():6.2f}  {study_low.sum() / low.sum():6.2f}"
            print(f"{law:22} {sums}  {ratios}", flush=True)


if __name__ == "__main__":
    main()
