"""Time of one fused step, and the time that the loop of ``solve`` and the call of ``ik.step`` add to it.

The problem has ten unit links in the plane, six circles to avoid, and joint centring. Figures are medians over
interleaved rounds with the tenth and ninetieth percentile, so that slow periods of the machine affect all rows alike.

    python benchmarks/step.py [--repeats 60] [--compiled] [--json FILE]
"""

from __future__ import annotations

import argparse
import json
import platform
import sys
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass

import casadi
import numpy as np

import jtik
from jtik.symbolic import function
from jtik.symbolic.compile import bind, to_c
from jtik_formulations import JointCentering, ObstacleAvoidance

LINKS = 10
CALLS = 2000
"""Calls timed together, which take milliseconds, far above the clock resolution."""
ITERATIONS = 1000
"""Iterations of the solve from which the overhead of the loop is computed."""
BOUNDARY = (9.999, 0.0)
"""A target at the boundary, which the transpose method approaches for thousands of iterations [m]."""
REACHED = (6.0, 3.0)
"""A target inside the workspace [m]."""

Timer = Callable[[], float]
"""Runs a batch of calls and returns the time of one call [s]."""


@dataclass(frozen=True)
class Figure:
    """Time of one call [us].

    Attributes:
        name: name of the row.
        median: median over the rounds.
        p10: tenth percentile.
        p90: ninetieth percentile.
    """

    name: str
    median: float
    p10: float
    p90: float


def field() -> list[jtik.Circle]:
    """Six circles around the arm."""
    return [jtik.Circle(center=(1.0 + 1.4 * k, 2.5 if k % 2 else -2.0), radius=0.3 + 0.05 * k) for k in range(6)]


def solver(strategy: str, options: dict[str, bool], *, criteria: bool = True) -> jtik.InverseKinematics:
    """The ten-link problem, with or without its two criteria."""
    wanted = 1.0 * JointCentering() + 0.3 * ObstacleAvoidance(field()) if criteria else None
    arm = jtik.Robot.planar(LINKS)
    return jtik.InverseKinematics(arm, jtik.FrameTask("tip"), criteria=wanted, strategy=strategy, **options)


def repeated(call: Callable[[], object]) -> Timer:
    """Mean time of CALLS consecutive calls."""

    def batch() -> float:
        begin = time.perf_counter()
        for _ in range(CALLS):
            call()
        return (time.perf_counter() - begin) / CALLS

    return batch


def step_alone(ik: jtik.InverseKinematics, q: np.ndarray, target: tuple[float, float]) -> Timer:
    """The fused step alone, always from the same configuration and initial state."""
    ik.solve(target, q0=q, max_iterations=0)  # writes target and tolerances to the inputs of the step
    runner = ik._engine.runners.solve
    runner.start(q)
    return repeated(runner.calls[0])


def model_alone(ik: jtik.InverseKinematics, q: np.ndarray, target: tuple[float, float], *, compiled: bool) -> Timer:
    """Residual, Jacobian, H and grad H in one function: the minimum that any method with them must evaluate."""
    problem = ik._engine.problem
    at, goal, parameters = problem.symbols()
    residual, H = problem.residual(at, goal), problem.criterion(at, parameters)
    outputs = [residual, problem.residual_jacobian(at, goal), H, problem.gradient(H, at)]
    model = function("jtik_base", [at, goal, parameters], outputs)
    model = to_c(model) if compiled else model
    results = [np.zeros(model.numel_out(i)) for i in range(model.n_out())]
    return repeated(bind(model, [q.copy(), np.array(target), ik.parameters.memory], results))


def one_iteration(ik: jtik.InverseKinematics, q: np.ndarray) -> Timer:
    """One iteration of a long solve: ITERATIONS minus a solve of one iteration, whose overhead is the same."""

    def seconds(iterations: int) -> tuple[float, int]:
        begin = time.perf_counter()
        solution = ik.solve(BOUNDARY, q0=q, max_iterations=iterations)
        return time.perf_counter() - begin, solution.iterations

    def batch() -> float:
        (long, spent), (short, one) = seconds(ITERATIONS), seconds(1)
        if spent != ITERATIONS or one != 1:
            raise RuntimeError(f"the solve stopped after {spent} iterations instead of {ITERATIONS}")
        return (long - short) / (ITERATIONS - 1)

    return batch


def one_solve(ik: jtik.InverseKinematics, q: np.ndarray) -> Timer:
    """A solve of one iteration: arguments, one step, diagnosis and Solution."""

    def batch() -> float:
        begin = time.perf_counter()
        for _ in range(CALLS // 50):
            ik.solve(BOUNDARY, q0=q, max_iterations=1)
        return (time.perf_counter() - begin) / (CALLS // 50)

    return batch


def one_step_call(ik: jtik.InverseKinematics, q: np.ndarray, target: tuple[float, float]) -> Timer:
    """``ik.step`` with arrays, as a controller calls it."""
    goal = np.array(target)
    return repeated(lambda: ik.step(q, goal))


def timed_step_call(options: dict[str, bool], distance: float, acceleration: float | None) -> Timer:
    """``ik.step(dt=0.002)`` of a Panda that rests, towards a pose at this distance [m] along y."""
    panda = jtik.Robot.builtin("panda")
    limits = jtik.Limits(velocity=1.5, acceleration=acceleration)
    ik = jtik.InverseKinematics(panda, jtik.FrameTask("tip", kind="pose"), limits=limits, **options)
    goal = panda.pose(panda.home)
    goal[:2, 3] += (-distance / 3, distance)

    def call() -> None:
        if acceleration is not None:
            ik.reset()  # each step begins at rest
        ik.step(panda.home, goal, dt=0.002)

    return repeated(call)


def interleaved(timers: dict[str, Timer], rounds: int) -> dict[str, np.ndarray]:
    """Times of every round by name [us]. Each round runs every timer once; the first round is discarded."""
    times: dict[str, list[float]] = {name: [] for name in timers}
    names = list(timers)
    for k in range(rounds + 1):
        for name in names[k % len(names) :] + names[: k % len(names)]:
            times[name].append(1e6 * timers[name]())
    return {name: np.array(each[1:]) for name, each in times.items()}


def figure(name: str, times: np.ndarray) -> Figure:
    """Median and percentiles."""
    p10, median, p90 = np.percentile(times, [10, 50, 90])
    return Figure(name, float(median), float(p10), float(p90))


def show(title: str, rows: list[Figure], reference: Figure, column: str) -> None:
    """Print a table with the ratio to ``reference``."""
    width = max(len(row.name) for row in rows)
    print(f"\n{title}\n{'':{width}}  median [us]     10 %     90 %  {column}")
    for row in rows:
        print(
            f"{row.name:{width}}  {row.median:11.2f}  {row.p10:7.2f}  {row.p90:7.2f}"
            f"  {row.median / reference.median:{len(column)}.2f}"
        )


def main() -> None:
    """Measure, print, and optionally write the figures."""
    parser = argparse.ArgumentParser(description="Time of a fused step and of the calls around it.")
    parser.add_argument("--repeats", type=int, default=60, help="rounds (default %(default)s)")
    parser.add_argument("--compiled", action="store_true", help="generate C and compile it")
    parser.add_argument("--json", metavar="FILE", help="also write the figures to FILE, '-' for standard output")
    arguments = parser.parse_args()
    if arguments.repeats < 1:
        parser.error("--repeats must be at least 1")
    options = {"compiled": arguments.compiled}
    q = np.linspace(0.05, 0.3, LINKS)

    names = list(jtik.strategies)
    steps = {name: solver(name, options) for name in names}
    alone = model_alone(steps[names[0]], q, REACHED, compiled=arguments.compiled)
    timers = {"kinematics, H and grad H alone": alone}
    timers |= {name: step_alone(ik, q, REACHED) for name, ik in steps.items()}
    times = interleaved(timers, arguments.repeats)
    fused = [figure(name, each) for name, each in times.items()]
    kind = "compiled C" if arguments.compiled else "virtual machine"
    show(f"ten links, six circles, two criteria: one step ({kind})", fused, fused[0], "x alone")

    plain = solver("transpose", options, criteria=False)
    separate = solver("transpose", options, criteria=False)
    timers = {
        "the step alone": step_alone(plain, q, BOUNDARY),
        "one iteration of solve": one_iteration(plain, q),
        "one ik.step": one_step_call(separate, q, BOUNDARY),
        "a solve of one iteration": one_solve(plain, q),
    }
    times = interleaved(timers, arguments.repeats)
    around = [figure(name, each) for name, each in times.items()]
    show(f"ten links, transpose, no criterion: calls around a step ({kind})", around, around[0], "x step")
    step_times = times["the step alone"]
    added = [
        figure("added by the loop, per iteration", times["one iteration of solve"] - step_times),
        figure("added by ik.step, per call", times["one ik.step"] - step_times),
    ]
    show("differences, round by round", added, around[0], "x step")

    timers = {
        "within the limits": timed_step_call(options, 2e-4, None),
        "at limits of velocity": timed_step_call(options, 0.02, None),
        "with limits of acceleration, within": timed_step_call(options, 1e-5, 10.0),
        "at limits of acceleration": timed_step_call(options, 0.02, 10.0),
    }
    times = interleaved(timers, arguments.repeats)
    limited = [figure(name, each) for name, each in times.items()]
    show(f"Panda, pose, hybrid: one ik.step(dt=0.002) ({kind})", limited, limited[0], "x within")

    if arguments.json:
        record = {
            "machine": f"{platform.machine()}, {platform.system()}",
            "python": platform.python_version(),
            "casadi": casadi.__version__,
            "compiled": arguments.compiled,
            "repeats": arguments.repeats,
            "unit": "us",
            "steps": [asdict(row) for row in fused],
            "around": [asdict(row) for row in around],
            "limited": [asdict(row) for row in limited],
            "added": [asdict(row) for row in added],
        }
        if arguments.json == "-":
            json.dump(record, sys.stdout, indent=2)
            print()
        else:
            with open(arguments.json, "w", encoding="utf-8") as file:
                json.dump(record, file, indent=2)


if __name__ == "__main__":
    main()
