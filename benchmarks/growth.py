"""How building, compiling, a step and memory grow with links, obstacles and criteria.

Each size is measured in a process of its own, in generated C from an empty cache: the processor time to build the
solver, that of the compiler, that of `ik.step`, and the memory that the solver takes. The exponent of a growth is the
slope of the logarithms from the middle size to the largest; linear is 1. What needs longer than the limit is left out.

    python benchmarks/growth.py [--repeats 3] [--limit 120] [--json benchmarks/growth.json] [--only links]

The figure is drawn from the recorded file by docs/performance_picture.py.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Any

FIGURES = ("build", "compile", "step", "memory")
"""Processor time to build [s] and to compile [s], of a step [us], and memory [MB]."""

CALLS = 2000
"""Most steps in the time of one."""
AT_MOST = 2.0
"""Longest time in which steps are repeated [s]."""
TOLERANCE = 0.25
"""What an exponent may exceed its bound by: noise of a tenth in two times that are a factor of four apart."""


@dataclass(frozen=True)
class Sweep:
    """One row of sizes.

    Attributes:
        what: what grows.
        strategy: the strategy.
        sizes: the sizes.
        make: size -> the arguments of the solver: robot, task, options.
        bound: largest exponent that is accepted: 1, or 2 for quadratic programs, whose matrix has the square of the
            joints as its entries.
    """

    what: str
    strategy: str
    sizes: tuple[int, ...]
    make: Callable[[int], tuple[Any, Any, dict[str, Any]]]
    bound: int = 1


def _links(n: int) -> tuple[Any, Any, dict[str, Any]]:
    import jtik
    from jtik_formulations import JointCentering

    robot = jtik.Robot.planar([2.0 / n] * n, lower=-2.5, upper=2.5)
    return robot, jtik.FrameTask("tip", "position"), {"criteria": JointCentering()}


def _obstacles(count: int) -> tuple[Any, Any, dict[str, Any]]:
    import jtik
    from jtik_formulations import ObstacleAvoidance

    robot = jtik.Robot.planar([0.2] * 10, lower=-2.5, upper=2.5)
    return robot, jtik.FrameTask("tip", "position"), {"criteria": ObstacleAvoidance(_circles(count))}


def _clearances(count: int) -> tuple[Any, Any, dict[str, Any]]:
    import jtik
    from jtik_formulations import JointCentering, ObstacleAvoidance

    robot = jtik.Robot.planar([0.2] * 10, lower=-2.5, upper=2.5)
    clear = jtik.Clearance(ObstacleAvoidance(_circles(count), bodies="links"), safe=0.01)
    return robot, jtik.FrameTask("tip", "position"), {"criteria": JointCentering(), "clearances": clear}


def _circles(count: int) -> list[Any]:
    """Circles beside the arm, none of which it touches."""
    import jtik

    return [jtik.Circle((0.03 * k - 1.0, -0.5 - 0.01 * k), 0.05) for k in range(count)]


def _criteria(count: int) -> tuple[Any, Any, dict[str, Any]]:
    import jtik
    from jtik_formulations import JointCentering, LimitBarrier

    some = [JointCentering(name=f"c{i}") if i % 2 else LimitBarrier(name=f"c{i}") for i in range(count)]
    return jtik.Robot.builtin("panda"), jtik.FrameTask("tip", "pose"), {"criteria": some or None}


LINKS, OBSTACLES, CRITERIA = (5, 10, 20, 50, 100), (1, 4, 16, 64), (0, 1, 2, 4, 8)
SWEEPS = (
    Sweep("links", "hybrid", LINKS, _links),
    Sweep("links", "weighted_qp", LINKS, _links, bound=2),
    Sweep("links", "hybrid+second_order", LINKS, _links, bound=2),
    Sweep("obstacles", "hybrid", OBSTACLES, _obstacles),
    Sweep("obstacles", "weighted_qp", OBSTACLES, _obstacles),
    Sweep("clearances", "weighted_qp", OBSTACLES, _clearances, bound=2),
    Sweep("criteria", "hybrid", CRITERIA, _criteria),
    Sweep("criteria", "weighted_qp", CRITERIA, _criteria),
)


def measured(sweep: Sweep, size: int) -> dict[str, float]:
    """The figures of one size, in this process."""
    import numpy as np

    import jtik

    jtik.InverseKinematics(jtik.Robot.planar(2), jtik.FrameTask(), strategy=sweep.strategy, compiled=False)  # loads
    robot, task, options = sweep.make(size)
    before = _memory()
    begin, children = time.process_time(), resource.getrusage(resource.RUSAGE_CHILDREN)
    ik = jtik.InverseKinematics(robot, task, strategy=sweep.strategy, compiled=True, **options)
    q = np.full(robot.nq, 0.8 / robot.nq) if robot.dimension == 2 else robot.home
    goal = q + 0.3 / robot.nq
    target = robot.position(goal) if robot.dimension == 2 else robot.pose(goal)
    ik.solve(target, q0=q)  # waits for what is compiled in the background
    ik.step(q, target)
    build, after = time.process_time() - begin, resource.getrusage(resource.RUSAGE_CHILDREN)
    compiled = after.ru_utime + after.ru_stime - children.ru_utime - children.ru_stime
    times, end = list[float](), time.perf_counter() + AT_MOST
    while len(times) < CALLS and time.perf_counter() < end:
        ik.reset()
        begin = time.thread_time()
        ik.step(q, target)
        times.append(time.thread_time() - begin)
    return {
        "build": build,
        "compile": compiled,
        "step": 1e6 * statistics.median(times),
        "memory": (_memory() - before) / 1e6,
    }


def _memory() -> int:
    """Memory of this process that is in use [bytes]."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * resource.getpagesize()


def in_a_process(number: int, size: int, limit: float) -> dict[str, float] | None:
    """The figures of one size, in a new process with an empty cache; None where it takes too long."""
    with tempfile.TemporaryDirectory() as cache:
        call = [sys.executable, __file__, "--measure", str(number), str(size)]
        environment = {**os.environ, "XDG_CACHE_HOME": cache, "OMP_NUM_THREADS": "1"}
        environment.setdefault("ZIG_GLOBAL_CACHE_DIR", str(Path.home() / ".cache" / "zig"))  # libraries of its own
        try:
            done = subprocess.run(call, env=environment, capture_output=True, text=True, timeout=limit, check=True)
        except subprocess.TimeoutExpired:
            return None
    found: dict[str, float] = json.loads(done.stdout.splitlines()[-1])
    return found


def exponent(sizes: list[int], values: list[float]) -> float:
    """The slope of the logarithms from the middle size to the largest; of sizes with 0, from the first after it."""
    sizes, values = sizes[-len(values) :], values[-len(sizes) :]
    known = [(s, v) for s, v in zip(sizes, values, strict=True) if s > 0]
    (s0, v0), (s1, v1) = known[(len(known) - 1) // 2], known[-1]
    return math.log(v1 / v0) / math.log(s1 / s0)


def run(sweep: Sweep, repeats: int, limit: float) -> dict[str, Any]:
    """The medians of all sizes, until one takes too long."""
    number, sizes = SWEEPS.index(sweep), list[int]()
    figures: dict[str, list[float]] = {name: [] for name in FIGURES}
    for size in sweep.sizes:
        found = [in_a_process(number, size, limit) for _ in range(repeats)]
        if any(each is None for each in found):
            break
        sizes.append(size)
        for name in FIGURES:
            figures[name].append(round(statistics.median(each[name] for each in found if each), 3))
    exponents = {name: round(exponent(sizes, figures[name]), 2) for name in FIGURES}
    return {
        "what": sweep.what,
        "strategy": sweep.strategy,
        "sizes": sizes,
        "left_out": [size for size in sweep.sizes if size not in sizes],
        "bound": sweep.bound,
        "figures": figures,
        "exponents": exponents,
        "judged": {name: value <= sweep.bound + TOLERANCE for name, value in exponents.items()},
    }


def main() -> None:
    """Measure, print and write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeats", type=int, default=3, help="processes of each size (%(default)s)")
    parser.add_argument("--limit", type=float, default=120.0, help="longest time of a process [s] (%(default)s)")
    parser.add_argument("--only", nargs="+", help="only these, such as links")
    parser.add_argument("--json", type=Path)
    parser.add_argument("--measure", nargs=2, type=int, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.measure:
        print(json.dumps(measured(SWEEPS[given.measure[0]], given.measure[1])))
        return
    rows = []
    for sweep in SWEEPS:
        if given.only and sweep.what not in given.only:
            continue
        row = run(sweep, given.repeats, given.limit)
        rows.append(row)
        print(f"{sweep.what}, {sweep.strategy}: {row['sizes']}, left out {row['left_out']}")
        for name in FIGURES:
            verdict = "" if row["judged"][name] else f"  above {sweep.bound}"
            print(f"  {name:8} {row['exponents'][name]:6.2f}{verdict}  {row['figures'][name]}", flush=True)
    if given.json:
        record = {"date": f"{date.today()}", "units": dict(zip(FIGURES, ("s", "s", "µs", "MB"), strict=True))}
        given.json.write_text(json.dumps({**record, "rows": rows}, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
