"""Cost of criteria: instructions and time of a step, growth with links, obstacles and criteria, time to build, rows.

Instructions are those of CasADi's virtual machine, and do not depend on the load of the machine; a call of a large
function counts as one. Times depend on the load, and are processor time. The exponent of a growth is the slope between
the two largest sizes, in logarithms.

    python benchmarks/criteria.py                       # everything, some minutes
    python benchmarks/criteria.py --only step growth
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

import jtik
from jtik.symbolic import function, jacobian, vertcat
from jtik.symbolic.compile import bind
from jtik.symbolic.generated_c import c_source
from jtik_formulations import JointCentering, LimitBarrier, ObstacleAvoidance, ObstacleBarrier, SelfCollision

LINKS = (5, 10, 20, 50, 100)
SLOTS = (1, 4, 16, 64)
COUNTS = (1, 2, 4, 8, 16)
PARTS = ("step", "growth", "build", "rows")

CALLS = 500
"""Calls timed together."""
ROUNDS = 15
"""Batches of calls, of which the median counts."""


@dataclass(frozen=True)
class Cost:
    """What a function costs.

    Attributes:
        instructions: of CasADi's virtual machine.
        microseconds: processor time of one call, the median of some batches; NaN where it was not measured.
    """

    instructions: int
    microseconds: float = math.nan


def cost(made: Any, arguments: list[np.ndarray], *, timed: bool = True) -> Cost:
    """The cost of a function at these arguments."""
    if not timed:
        return Cost(made.n_instructions())
    results = [np.zeros(made.size_out(i)) for i in range(made.n_out())]
    call = bind(made, arguments, results)
    times = []
    for _ in range(ROUNDS):
        begin = time.process_time()
        for _ in range(CALLS):
            call()
        times.append((time.process_time() - begin) / CALLS)
    return Cost(made.n_instructions(), 1e6 * float(np.median(times)))


def parts_of(ik: jtik.InverseKinematics, *, timed: bool = True) -> dict[str, Cost]:
    """The costs of kinematics, of these with H and its gradient, of one step, and of all frames.

    Kinematics are residual and Jacobian of the task, all frames the positions of all frames with their Jacobians.
    """
    problem, runner = ik._engine.problem, ik._engine.runners.solve
    at, goal, parameters = problem.symbols()
    kinematics = [problem.residual(at, goal), problem.residual_jacobian(at, goal)]
    H, gradient = problem.criterion_gradient(at, parameters)
    q, inputs = np.asarray(ik.robot.home, dtype=float), runner.inputs
    target, live = np.asarray(inputs.target), ik.parameters.memory
    at_q = ik.robot.at(at)
    places = vertcat(*[at_q.position(frame) for frame in ik.robot.moving_frames])
    frames = function("frames", [at], [places, jacobian(places, at)])
    alone = function("kinematics", [at, goal], kinematics)
    both = function("with_gradient", [at, goal, parameters], [*kinematics, H, gradient])
    return {
        "kinematics": cost(alone, [q, target], timed=timed),
        "with H, gradient": cost(both, [q, target, live], timed=timed),
        "frames": cost(frames, [q], timed=timed),
        "step": cost(runner.fused.function, [q, *inputs, runner.first_state], timed=timed),
    }


def spheres(count: int, dimension: int = 3) -> list[Any]:
    """Balls around the base, at different places."""
    rng = np.random.default_rng(0)
    return [
        jtik.Sphere(c, 0.1) if dimension == 3 else jtik.Circle(c, 0.1) for c in rng.uniform(-3, 3, (count, dimension))
    ]


def panda(criteria: Any) -> jtik.InverseKinematics:
    """A Panda with a pose, and these criteria."""
    return jtik.InverseKinematics(jtik.Robot.builtin("panda"), jtik.FrameTask("tip", "pose"), criteria=criteria)


def planar(links: int, criteria: Any) -> jtik.InverseKinematics:
    """An arm in the plane with the position of its tip, and these criteria."""
    arm = jtik.Robot.planar(links, lower=-2.5, upper=2.5)
    return jtik.InverseKinematics(arm, jtik.FrameTask("tip", "position"), criteria=criteria)


def steps() -> None:
    """Print the costs of single problems."""
    body, field = SelfCollision(), spheres(8)
    problems = {
        "Panda, joint centring": lambda: panda(JointCentering()),
        "Panda, self-collision": lambda: panda(body),
        "Panda, 8 spheres, joints": lambda: panda(ObstacleBarrier(field)),
        "Panda, 8 spheres, its capsules": lambda: panda(ObstacleBarrier(field, bodies="shapes")),
        "Panda, 8 spheres, its capsules, and self-collision": lambda: panda(
            [ObstacleBarrier(field, bodies="shapes"), body]
        ),
        "ten links, 6 circles, joints": lambda: planar(10, ObstacleAvoidance(spheres(6, 2))),
        "ten links, 6 circles, links": lambda: planar(10, ObstacleAvoidance(spheres(6, 2), bodies="links")),
    }
    print("| instructions (time) | kinematics | all frames | kinematics, H, gradient | x frames | step | x frames |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    for name, made in problems.items():
        costs = parts_of(made())
        frames, both, step = (costs[key] for key in ("frames", "with H, gradient", "step"))
        ratios = [
            f"{each.instructions / frames.instructions:.1f} ({each.microseconds / frames.microseconds:.1f})"
            for each in (both, step)
        ]
        texts = [
            f"{costs[key].instructions} ({costs[key].microseconds:.1f} µs)"
            for key in ("kinematics", "frames", "with H, gradient", "step")
        ]
        print("| " + " | ".join([name, *texts[:3], ratios[0], texts[3], ratios[1]]) + " |", flush=True)


def growth() -> None:
    """Print how instructions grow."""
    field = spheres(6, 2)
    some = [JointCentering(name=f"c{i}") if i % 2 else LimitBarrier(name=f"c{i}") for i in range(max(COUNTS))]
    sweeps: dict[str, tuple[Iterable[int], Callable[[int], jtik.InverseKinematics]]] = {
        "links, 6 circles, joints": (LINKS, lambda n: planar(n, ObstacleAvoidance(field))),
        "links, 6 circles, links": (LINKS, lambda n: planar(n, ObstacleBarrier(field, bodies="links"))),
        "links, limits": (LINKS, lambda n: planar(n, LimitBarrier())),
        "slots, ten links": (SLOTS, lambda k: planar(10, ObstacleBarrier([], capacity=k, bodies="links"))),
        "slots, Panda's capsules": (SLOTS, lambda k: panda(ObstacleBarrier([], capacity=k, bodies="shapes"))),
        "criteria, Panda": (COUNTS, lambda k: panda(some[:k])),
    }
    print("\n| instructions of the step; of kinematics, H, gradient | at each size | exponents |")
    print("| --- | --- | --- |")
    for name, (sizes, made) in sweeps.items():
        found = [parts_of(made(size), timed=False) for size in sizes]
        step, both = ([each[key].instructions for each in found] for key in ("step", "with H, gradient"))
        texts = [f"{size}: {a}; {b}" for size, a, b in zip(sizes, step, both, strict=True)]
        slopes = [f"{exponent(list(sizes), counts):.2f}" for counts in (step, both)]
        print(f"| {name} | {', '.join(texts)} | {'; '.join(slopes)} |", flush=True)


def exponent(sizes: list[int], counts: list[int]) -> float:
    """The slope of the logarithms between the two largest sizes."""
    return math.log(counts[-1] / counts[-2]) / math.log(sizes[-1] / sizes[-2])


def builds() -> None:
    """Print the processor time that it takes to build solvers with 16 slots."""
    rows = {
        "ten links, 16 slots, joints": lambda: planar(10, ObstacleAvoidance([], capacity=16)),
        "ten links, 16 slots, links": lambda: planar(10, ObstacleAvoidance([], capacity=16, bodies="links")),
        "Panda, 16 slots, joints": lambda: panda(ObstacleBarrier([], capacity=16)),
        "Panda, 16 slots, its capsules": lambda: panda(ObstacleBarrier([], capacity=16, bodies="shapes")),
        **{
            f"Panda, 16 slots for {kind} obstacles, its capsules": lambda kind=kind: panda(
                ObstacleBarrier([], capacity={kind: 16}, bodies="shapes")
            )
            for kind in ("capsule", "box", "half_space", "cylinder")
        },
        "Panda, self-collision": lambda: panda(SelfCollision()),
        "Panda, 8 boxes, 8 half-spaces, its capsules, and self-collision": lambda: panda(
            [ObstacleBarrier([], capacity={"box": 8, "half_space": 8}, bodies="shapes"), SelfCollision()]
        ),
    }
    print("\n| processor time [s] | the solver | its first solve |\n| --- | --- | --- |")
    panda(JointCentering())  # loads modules
    for name, made in rows.items():
        begin = time.process_time()
        ik = made()
        built = time.process_time()
        robot = ik.robot
        target = robot.position(robot.home) if robot.dimension == 2 else robot.pose(robot.home)
        ik.solve(target, max_iterations=5)
        print(f"| {name} | {built - begin:.2f} | {time.process_time() - built:.2f} |", flush=True)


def with_rows(robot: jtik.Robot, *measures: Any) -> jtik.InverseKinematics:
    """A robot that keeps all distances of some measures, by ``weighted_qp``."""
    clearances = [jtik.Clearance(each, name=f"of{i}") for i, each in enumerate(measures)]
    task = jtik.FrameTask(robot.tip, "position" if robot.dimension == 2 else "pose")
    return jtik.InverseKinematics(robot, task, criteria=JointCentering(), strategy="weighted_qp", clearances=clearances)


def rows() -> None:
    """Print what clearances cost to build, as text of generated C, and in a step of the virtual machine."""
    ten = jtik.Robot.planar(10, lower=-2.5, upper=2.5, velocity_limit=2.0)
    arm = jtik.Robot.builtin("panda")
    problems = {
        **{
            f"ten links, {k} circles": lambda k=k: with_rows(ten, ObstacleAvoidance(spheres(k, 2), bodies="links"))
            for k in SLOTS
        },
        **{
            f"Panda's capsules, {k} spheres": lambda k=k: with_rows(arm, ObstacleAvoidance(spheres(k), bodies="shapes"))
            for k in (1, 8)
        },
        "Panda, self-collision": lambda: with_rows(arm, SelfCollision()),
    }
    print("\n| clearances | distances | solver and first step [s] | lines of C | step [µs] |")
    print("| --- | --- | --- | --- | --- |")
    for name, made in problems.items():
        begin = time.process_time()
        ik = made()
        robot = ik.robot
        target = robot.position(robot.home) if robot.dimension == 2 else robot.pose(robot.home)
        ik.step(robot.home, target, dt=0.02)
        built = time.process_time() - begin
        runner, _ = ik._engine.runners.timed_step
        lines = c_source(runner.fused.parts.joined()).count("\n")
        times = []
        for _ in range(ROUNDS):
            begin = time.process_time()
            for _ in range(CALLS // 10):
                runner.calls[0]()
            times.append((time.process_time() - begin) / (CALLS // 10))
        count = len(ik._engine.problem.measured.pairs)
        print(f"| {name} | {count} | {built:.1f} | {lines} | {1e6 * np.median(times):.0f} |", flush=True)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="+", choices=PARTS, default=PARTS)
    wanted = parser.parse_args().only
    for name, part in zip(PARTS, (steps, growth, builds, rows), strict=True):
        if name in wanted:
            part()


if __name__ == "__main__":
    main()
