"""Measurements of the demo, which use no formulation: distances in NumPy, and a clock."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jtik.demo.scene import Scene
from jtik.geometry import Ball
from jtik.plotting import Skeleton
from jtik.result.solution import Solution, Status
from jtik.solver import InverseKinematics
from jtik.types import Array

POSITION_TOLERANCE = 1e-6
"""Position tolerance of every solve of the demo [m]."""

V_ROUNDING = POSITION_TOLERANCE**2 / 2
"""An increase of V = |error|^2 / 2 [m^2] below this one does not count: V is within the tolerance at both ends."""

MAX_ITERATIONS = 2000
"""Maximum number of iterations of every solve of the demo."""


@dataclass(frozen=True)
class PathResult:
    """The solves along the path, one a target.

    Attributes:
        q: configurations (k, n) [rad].
        statuses: status of each solve.
        residuals: distances of the end effector from its target (k,) [m].
        iterations: numbers of iterations (k,).
        seconds: time of all solves together [s].
        joint_clearance: smallest distance of a joint or the end effector from an obstacle's surface (k,) [m].
        link_clearance: smallest distance of a point of any link from an obstacle's surface (k,) [m].
    """

    q: Array
    statuses: tuple[Status, ...]
    residuals: Array
    iterations: NDArray[np.int_]
    seconds: float
    joint_clearance: Array
    link_clearance: Array

    @property
    def reached(self) -> int:
        """Number of targets that were reached to the tolerance."""
        return int((self.residuals <= POSITION_TOLERANCE).sum())

    @property
    def complete(self) -> bool:
        """Whether every target was reached."""
        return self.reached == len(self.residuals)

    @property
    def step_seconds(self) -> float:
        """Solve time per iteration [s]."""
        return self.seconds / max(int(self.iterations.sum()), 1)


@dataclass(frozen=True)
class StrategyResult:
    """One strategy's solve of the final target from the scene's start.

    Attributes:
        strategy: name of the strategy.
        status: status of the solve.
        iterations: number of iterations.
        residual: distance of the end effector from the target [m].
        largest_rise: largest increase of V = |error|^2 / 2 in an iteration [m^2]; 0 where V never increases.
        H: criterion at the end.
        joint_clearance: smallest distance of a joint from an obstacle's surface at the end [m].
        link_clearance: smallest distance of a link from an obstacle's surface at the end [m].
        step_seconds: solve time per iteration, median of several solves after the first [s].
        q: configuration at the end (n,) [rad].
    """

    strategy: str
    status: Status
    iterations: int
    residual: float
    largest_rise: float
    H: float
    joint_clearance: float
    link_clearance: float
    step_seconds: float
    q: Array


def clearances(links: ArrayLike, obstacles: Sequence[Ball]) -> tuple[Array, Array]:
    """Distances of links from the surfaces of obstacles.

    Args:
        links: both ends of every link (..., links, 2, 2) [m].
        obstacles: circles and points.

    Returns:
        Two arrays (..., links, obstacles) [m], negative inside: distances of the links' outer ends, and of the links.
    """
    ends = np.asarray(links, dtype=float)[..., None, :, :]
    inner, outer = ends[..., 0, :], ends[..., 1, :]
    along = outer - inner
    centers = np.array([obstacle.center for obstacle in obstacles])
    radii = np.array([obstacle.radius for obstacle in obstacles])
    share = ((centers - inner) * along).sum(-1) / (along**2).sum(-1)
    closest = inner + np.clip(share, 0, 1)[..., None] * along
    return np.linalg.norm(outer - centers, axis=-1) - radii, np.linalg.norm(closest - centers, axis=-1) - radii


def follow_path(
    scene: Scene, targets: Array, *, avoid: bool = True, advance: Callable[[], object] = lambda: None
) -> PathResult:
    """Solve one target after the other, each from the configuration at which the last solve ended.

    Args:
        scene: the scene.
        targets: positions (k, 2) [m].
        avoid: whether obstacle avoidance is a criterion.
        advance: called after each target.
    """
    ik = scene.solver(avoid=avoid)
    q: ArrayLike = scene.start
    solutions: list[Solution] = []
    for target in targets:
        solution = ik.solve(target, q0=q, max_iterations=MAX_ITERATIONS, position_tolerance=POSITION_TOLERANCE)
        solutions.append(solution)
        q = solution.q
        advance()
    table = np.array([solution.q for solution in solutions])
    joints, links = clearances(Skeleton(scene.robot).links(table), scene.obstacles)
    return PathResult(
        q=table,
        statuses=tuple(solution.status for solution in solutions),
        residuals=np.array([solution.position_error for solution in solutions]),
        iterations=np.array([solution.iterations for solution in solutions]),
        seconds=sum(solution.seconds for solution in solutions),
        joint_clearance=joints.min((1, 2)),
        link_clearance=links.min((1, 2)),
    )


def try_strategy(scene: Scene, name: str, target: Array, runs: int) -> StrategyResult:
    """Solve one target from the scene's start: once with a trace, and several times for the time.

    Args:
        scene: the scene.
        name: name of the strategy.
        target: position (2,) [m].
        runs: number of solves for the time.
    """
    ik = scene.solver(name)
    traced = _solved(ik, target, scene.start, trace=True)
    assert traced.trace is not None
    V = traced.trace.error**2 / 2
    rise = float(np.diff(V).max(initial=0.0))
    joints, links = clearances(Skeleton(scene.robot).links(traced.q), scene.obstacles)
    return StrategyResult(
        strategy=name,
        status=traced.status,
        iterations=traced.iterations,
        residual=traced.position_error,
        largest_rise=rise if rise > V_ROUNDING else 0.0,
        H=traced.cost,
        joint_clearance=float(joints.min()),
        link_clearance=float(links.min()),
        step_seconds=step_time(ik, target, scene.start, runs),
        q=traced.q,
    )


def step_time(ik: InverseKinematics, target: ArrayLike, q0: ArrayLike, runs: int) -> float:
    """Solve time per iteration [s]: the median of ``runs`` solves after a first one that does not count."""
    times = []
    for _ in range(runs + 1):
        solution = ik.solve(target, q0=q0, max_iterations=MAX_ITERATIONS, position_tolerance=POSITION_TOLERANCE)
        times.append(solution.seconds / max(solution.iterations, 1))
    return statistics.median(times[1:])


def _solved(ik: InverseKinematics, target: ArrayLike, q0: ArrayLike, trace: bool = False) -> Solution:
    """A solve with the tolerances of the demo."""
    return ik.solve(target, q0=q0, max_iterations=MAX_ITERATIONS, position_tolerance=POSITION_TOLERANCE, trace=trace)
