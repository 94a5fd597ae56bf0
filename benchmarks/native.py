"""Steps and solves in generated C beside other libraries: what a controller and what a planner ask for.

**Steps**, see native_steps.py: a Panda at velocity limits and on a path, and ten links among four circles, hot and
cold, beside placo, mink and pink.

**Solves** of a Panda, per second: one target at a time and side by side in vector registers, by one thread and by two,
beside the Robotics Toolbox and optik. Every answer counts only where Pinocchio's forward kinematics, on the file
itself, finds it within 1e-6 m and 1e-6 rad of its target and within the limits. Two kinds of starts: the middle of the
limits for all, with up to 100 restarts; and near ones, where each joint is up to 0.1 rad from the configuration that
the target was made of, as along a path.

**Calls**, see native_calls.py: one `solve` a target from the middle of the limits, one start after the other and in
lanes, beside the same libraries: mean and percentiles of the times.

    python benchmarks/native.py [--only steps] [--targets 20000] [--rounds 7] [--cpu] [--json figures.json]

The rows of a round follow one another, and each round begins with another row. Times are medians with the tenth and
ninetieth percentile. The peers solve the first targets only, and start in the middle. They are installed by

    python -m pip install mink pin-pink "placo==0.10.2" roboticstoolbox-python optik-py example-robot-data

A library that is not installed has a row that says so.
"""

from __future__ import annotations

import argparse
import json
import math
import time
from collections.abc import Callable
from datetime import date
from functools import partial
from pathlib import Path
from typing import Any

import native_calls
import native_steps  # sets the number of threads, so it is imported before NumPy

# isort: split
import numpy as np
from ik_arms import FILE_SLACK, Arm, check, read_arm
from ik_solvers import RESTARTS, Accuracy, Builder, optik, toolbox
from packages import versions

import jtik

Array = np.ndarray
ACCURACY = Accuracy(1e-6, 1e-6)
PACKAGES = (
    "numpy",
    "casadi",
    "daqp",
    "ziglang",
    "mink",
    "pin-pink",
    "pin",
    "placo",
    "roboticstoolbox-python",
    "optik-py",
)
NEAR = 0.1
"""Largest distance of a joint from the answer in a near start [rad]."""
PEERS: dict[str, Builder] = {"Robotics Toolbox ik_LM": toolbox, "optik": optik}

Found = jtik.SolutionBatch | list[Array | None]
"""A batch, or for each target a configuration or None."""

Solve = Callable[[], Found]
"""() -> what is found for its targets."""


def solver(arm: Arm, strategy: str) -> jtik.InverseKinematics:
    """The solver of jtik."""
    robot = jtik.Robot.from_urdf(arm.path, tip=arm.tip)
    task = jtik.FrameTask(arm.tip, kind="pose", stiffness=[1, 1, 1, 0.06, 0.06, 0.06])
    joints = [link.name for link in arm.links]
    return jtik.InverseKinematics(robot, task, strategy=strategy, joints=joints, at=np.zeros(robot.nq), compiled=True)


def ours(arm: Arm, strategy: str, targets: Array, starts: dict[str, Array]) -> dict[str, Solve]:
    """The rows of jtik."""
    ik = solver(arm, strategy)

    def solve(start: str, threads: int, lanes: bool) -> jtik.SolutionBatch:
        return ik.solve_batch(targets, q0=starts[start], restarts=RESTARTS, threads=threads, lanes=lanes)

    return {
        f"{start}: {'lanes' if lanes else 'one at a time'}, {threads} thread{'s' * (threads > 1)}": partial(
            solve, start, threads, lanes
        )
        for start in starts
        for lanes in (False, True)
        for threads in (1, 2)
    }


def peers(arm: Arm, targets: Array) -> dict[str, Solve | str]:
    """The rows of the other libraries; a text where one is not installed."""
    rows: dict[str, Solve | str] = {}
    for name, build in PEERS.items():
        try:
            prepared = build(arm, ACCURACY)
        except ImportError as error:
            rows[name] = f"not installed: {error}"
            continue
        converted = [prepared.convert(target) for target in targets]
        rows[name] = lambda solve=prepared.solve, given=converted: [solve(target) for target in given]
    return rows


def right(arm: Arm, targets: Array, found: Found) -> int:
    """How many answers are on target and within the limits, by Pinocchio."""
    count = 0
    answers: list[Array | None] = (
        found
        if isinstance(found, list)
        else [q if good else None for q, good in zip(found.q, found.converged, strict=True)]
    )
    for target, q in zip(targets, answers, strict=True):
        if q is not None:
            at = check(arm, target, q)
            on_target = at.position <= ACCURACY.position + FILE_SLACK
            count += at.within and on_target and at.orientation <= ACCURACY.orientation + FILE_SLACK
    return count


def main() -> None:
    """Measure what is asked for, print it and write it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", choices=["steps", "solves", "calls"])
    parser.add_argument("--targets", type=int, default=20_000)
    parser.add_argument("--of-peers", type=int, default=300, help="number of targets of the other libraries")
    parser.add_argument("--calls", type=int, default=2000, help="number of targets of single calls")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--strategy", default="damped")
    parser.add_argument("--cpu", action="store_true", help="time of the processor, on a machine that others use, too")
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    figures: dict[str, Any] = {"date": f"{date.today()}", "packages": versions(PACKAGES), "cpu": given.cpu}
    if given.only in (None, "steps"):
        steps = native_steps.measured(given.rounds, time.thread_time if given.cpu else time.perf_counter)
        native_steps.show(steps)
        figures["steps"] = [row if isinstance(row, str) else row.record() for row in steps]
    if given.only in (None, "solves"):
        figures["solves"] = solves(given)
    if given.only in (None, "calls"):
        found = calls(given)
        native_calls.show(found)
        figures["calls"] = [row.record() for row in found]
    if given.json:
        given.json.write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")


def calls(given: argparse.Namespace) -> list[native_calls.CallTimes]:
    """Measure solves for one target a call."""
    arm, generator = read_arm("panda"), np.random.default_rng(0)
    targets = np.array([arm.pose(arm.draw(generator)) for _ in range(given.calls)])
    ik, middle = solver(arm, given.strategy), arm.middle()

    def reached(found: jtik.Solution) -> Array | None:
        return found.q if found.converged else None

    own: dict[str, native_calls.Call] = {
        "solve": lambda target: reached(ik.solve(target, q0=middle, restarts=RESTARTS)),
        "lanes": lambda target: reached(ik.solve(target, q0=middle, restarts=RESTARTS, lanes=True)),
        "lanes, nearest": lambda target: reached(
            ik.solve(target, q0=middle, restarts=RESTARTS, lanes=True, nearest=True)
        ),
    }
    rows: dict[str, tuple[native_calls.Call, list[Any]]] = {name: (call, list(targets)) for name, call in own.items()}
    for name, build in PEERS.items():
        try:
            prepared = build(arm, ACCURACY)
        except ImportError as error:
            print(f"{name:34} not installed: {error}")
            continue
        rows[name] = prepared.solve, [prepared.convert(target) for target in targets]
    clock = time.thread_time_ns if given.cpu else time.perf_counter_ns
    return native_calls.measured(rows, given.rounds, clock, lambda answers: right(arm, targets, answers))


def solves(given: argparse.Namespace) -> dict[str, Any]:
    """Measure and print the solves."""
    clock = time.process_time if given.cpu else time.perf_counter
    arm, generator = read_arm("panda"), np.random.default_rng(0)
    made_of = np.array([arm.draw(generator) for _ in range(given.targets)])
    targets = np.array([arm.pose(q) for q in made_of])
    near = np.clip(made_of + generator.uniform(-NEAR, NEAR, made_of.shape), *arm.bounds())
    rows: dict[str, Solve | str] = {}
    rows |= ours(arm, given.strategy, targets, {"from the middle": arm.middle(), "near": near})
    rows |= peers(arm, targets[: given.of_peers])
    running = {name: row for name, row in rows.items() if not isinstance(row, str)}
    answers = {name: row() for name, row in running.items()}  # compiles, and is not timed
    times: dict[str, list[float]] = {name: [] for name in running}
    names = list(running)
    for k in range(given.rounds):
        for name in names[k % len(names) :] + names[: k % len(names)]:
            begin = clock()
            running[name]()
            times[name].append((clock() - begin) / len(answers[name]))
    figures: dict[str, Any] = {}
    print(f"{'':42} {'µs a target (10 to 90 %)':>28} {'a second':>10} {'right':>9}")
    for name, row in rows.items():
        if isinstance(row, str):
            print(f"{name:42} {row}")
            continue
        low, median, high = np.percentile(times[name], [10, 50, 90]) * 1e6
        share = right(arm, targets[: len(answers[name])], answers[name]) / len(answers[name])
        figures[name] = {"median": median, "low": low, "high": high, "right": share, "targets": len(answers[name])}
        span = f"{median:.2f} ({low:.2f} to {high:.2f})"
        print(f"{name:42} {span:>28} {math.floor(1e6 / median):>10,} {100 * share:>7.2f} %")
    return figures


if __name__ == "__main__":
    main()
