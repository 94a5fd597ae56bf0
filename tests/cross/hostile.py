"""Hostile problems on random trees, and what is wrong with an answer, judged by kinematics of their own.

Wrong is an exception, a NaN, a success off target, a limit of position, velocity or acceleration that is broken, a
clearance that is broken anywhere on the way, and a null-space displacement that moves an end effector.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

import jtik
from jtik import Status
from jtik.registry import strategy_of
from jtik_formulations import JointCentering, ObstacleAvoidance

from ..conftest import as_moved, under_limits
from .random_trees import Tree, random_configuration, random_tree

LEAKAGE = 1e-10
"""Bound of |J nu| / |J|, relative to the longer one of nu and the whole step, at poses of full rank.

With clearances, where the share of the task displacement is a variable of the same quadratic program, relative to 1 if
that is longer.
"""

SINGULAR_LEAKAGE = 1e-7
"""The same at poses where J has, without the joints that stay, a relative singular value below this."""

ITERATIONS = 30
"""Iterations of a solve."""

TOLERANCE = 1e-6
"""Largest error of a success [m] or, for small robots, of a link's length; [rad]."""

ROUNDING = 1e-9
"""Rounding of limits, relative to their size, and of distances, relative to the robot's."""

SAMPLES = 12
"""Configurations on the path of a step at which distances are measured."""

BALLS = 2
"""Obstacles."""


@jtik.criterion
def waves(q, robot):
    """A criterion that is convex in some regions and concave in others."""
    import casadi

    return sum(casadi.cos(2 * q[i] + 0.3 * i) for i in range(robot.nq))


@dataclass(frozen=True)
class Setup:
    """A solver for random problems.

    Attributes:
        name: strategy, and what else is part of it.
        tree: its robot.
        ik: the solver.
        kinds: kind of the task of each tip.
        limited: whether position limits hold.
        speed: largest velocity [rad/s] or [m/s], and largest acceleration or None.
        clear: whether it has clearances.
        safe: smallest distance allowed [m].
        log: one entry for each call of the step with a record: where it was made, q or the explorer, and the record.
    """

    name: str
    tree: Tree
    ik: jtik.InverseKinematics
    kinds: tuple[str, ...]
    limited: bool
    speed: tuple[float, float | None]
    clear: bool
    safe: float
    log: list[tuple[np.ndarray, np.ndarray]]


def strategies() -> list[str]:
    """Every registered strategy, and every task step with each other secondary term."""
    names = list(jtik.strategies)
    for name in jtik.strategies:
        for secondary in jtik.secondaries:
            try:
                strategy_of(f"{name}+{secondary}")
            except jtik.ArgumentError:
                continue
            if secondary != "gradient":
                names.append(f"{name}+{secondary}")
    return names


def setup(strategy: str, rng: np.random.Generator) -> Setup:
    """A random robot with this strategy."""
    tree = random_tree(rng)
    d, scale = tree.robot.dimension, tree.scale
    tips = tree.tips if rng.random() < 0.5 else tree.tips[:1]
    kinds = tuple("position" if d == 2 or rng.random() < 0.6 else "pose" for _ in tips)
    tasks = [jtik.FrameTask(tip, kind=kind, priority=k) for k, (tip, kind) in enumerate(zip(tips, kinds, strict=True))]
    clear = bool(strategy_of(strategy).supports_clearances() and rng.random() < 0.6)
    field = [(jtik.Circle if d == 2 else jtik.Sphere)(np.full(d, 100 * scale), 0.3 * scale) for _ in range(BALLS)]
    criterion = [None, JointCentering(), waves, JointCentering() + 0.1 * ObstacleAvoidance(field)][rng.integers(4)]
    safe, margin = 0.05 * scale, 0.02 * scale
    clearance = None
    if clear:
        measure = ObstacleAvoidance(field, bodies="links")
        clearance = jtik.Clearance(measure, safe=safe, margin=margin, influence=0.5 * scale)
    limited = bool(rng.random() < 0.8)
    speed = (float(rng.uniform(0.5, 3)), float(rng.uniform(5, 50)) if rng.random() < 0.5 else None)
    ik = jtik.InverseKinematics(
        tree.robot,
        tasks,
        criteria=criterion,
        strategy=strategy,
        limits=jtik.Limits(position=limited, velocity=speed[0], acceleration=speed[1]),
        clearances=clearance,
        joints="all",
    )
    log: list[tuple[np.ndarray, np.ndarray]] = []
    runner = ik._engine.runners.traced_solve

    layout = runner.fused.state.slices

    def logged(call, q, state):
        def both():
            explores = "exploring" in layout and bool(state[layout["exploring"]][0])
            before = (state[layout["explorer"]] if explores else q).copy()
            call()
            log.append((before, runner.record.copy()))

        return both

    runner.calls = tuple(logged(*memory) for memory in zip(runner.calls, runner.q, runner.state, strict=True))
    what = f"{strategy}, {'+'.join(kinds)}, {scale:g} m{', clearances' * clear}{', no limits' * (not limited)}"
    return Setup(f"{what}, {criterion!r}", tree, ik, kinds, limited, speed, clear, safe, log)


@dataclass(frozen=True)
class Problem:
    """A start, targets by tip, obstacles, and a tolerance of positions."""

    q0: np.ndarray
    targets: tuple[np.ndarray, ...]
    centers: np.ndarray
    tolerance: float
    until: str


def problem(case: Setup, rng: np.random.Generator) -> Problem:
    """A random problem: some are out of reach, start at limits or outside them."""
    tree, d = case.tree, case.tree.robot.dimension
    q0 = random_configuration(tree, rng, at_limit=rng.choice([0.0, 0.0, 0.5]))
    if rng.random() < 0.1 and not case.clear:
        q0 = q0 + rng.uniform(-2, 2) * np.eye(len(q0))[tree.robot.scalar_q[0]]
    poses, targets = tree.poses(random_configuration(tree, rng)), []
    for tip, kind in zip(tree.tips, case.kinds, strict=False):
        pose = poses[tip].copy()
        if rng.random() < 0.2:
            pose[:d, 3] *= rng.uniform(2, 20)
        targets.append(pose if kind == "pose" else pose[:d, 3])
    centers = np.full((BALLS, d), 100 * tree.scale)
    for _ in range(50 if case.clear else 0):
        drawn = rng.normal(size=(BALLS, d)) * 2 * tree.scale
        if tree.distances(q0, drawn, np.full(BALLS, 0.3 * tree.scale)).min() > rng.choice([0.5, 1.0]) * case.safe:
            centers = drawn
            break
    tolerance = TOLERANCE * (min(tree.scale, 1.0) if rng.random() < 0.5 else max(tree.scale, 1e-2))
    return Problem(q0, tuple(targets), centers, tolerance, ("reached", "stationary")[rng.integers(2)])


def answers(case: Setup, rng: np.random.Generator, count: int) -> Iterator[tuple[Problem, str, list[tuple[str, str]]]]:
    """Random problems, the status of each, and what is wrong with it: its kind and a sentence."""
    for number in range(count):
        given = problem(case, rng)
        try:
            status, wrong = solved(case, given)
            if number % 5 == 0:
                wrong += stepped(case, given)
        except Exception as error:  # whatever it is, it is a finding
            status, wrong = "exception", [("exception", repr(error))]
        yield given, status, wrong


def target_of(case: Setup, given: Problem) -> object:
    """The target as a solver takes it."""
    names = [task.name for task in case.ik.tasks.tasks]
    return given.targets[0] if len(names) == 1 else dict(zip(names, given.targets, strict=True))


def place_obstacles(case: Setup, given: Problem) -> None:
    """Move the obstacles of clearances and criterion."""
    for name in ("clearance.centers", "obstacle_avoidance.centers"):
        if name in case.ik.parameters:
            case.ik.parameters[name] = given.centers


def solved(case: Setup, given: Problem) -> tuple[str, list[tuple[str, str]]]:
    """The status of one solve, and what is wrong with it."""
    case.log.clear()
    place_obstacles(case, given)
    solution = case.ik.solve(
        target_of(case, given),
        q0=given.q0,
        max_iterations=ITERATIONS,
        position_tolerance=given.tolerance,
        until=given.until,
        trace=True,
    )
    q, wrong = solution.trace.q, []
    if not (np.isfinite(q).all() and np.isfinite(solution.q).all()):
        return solution.status.name, [("NaN", f"q is not finite, {solution.status.name}")]
    if solution.status is Status.NOT_FINITE:
        wrong.append(("NaN", "the status NOT_FINITE"))
    if solution.status.on_target or solution.converged:
        wrong += off_target(case, given, solution.q)
    if case.limited and case.tree.outside(under_limits(case.ik.robot, q)) > ROUNDING:
        wrong.append(("limit", f"outside its limits by {case.tree.outside(q):.3g}"))
    if case.clear:
        wrong += too_near(case, given, as_moved(case.ik.robot, q, case.limited))
    if case.ik._engine.problem.has_criterion:
        wrong += leaking(case)
    return solution.status.name, wrong


def off_target(case: Setup, given: Problem, q: np.ndarray) -> list[tuple[str, str]]:
    """What is wrong with a success at q."""
    poses, squared, angle = case.tree.poses(q), 0.0, 0.0
    for tip, kind, target in zip(case.tree.tips, case.kinds, given.targets, strict=False):
        d = case.tree.robot.dimension
        place = target[:3, 3] if kind == "pose" else target
        squared += float(((poses[tip][:d, 3] - place) ** 2).sum())
        if kind == "pose":
            angle = np.hypot(angle, Rotation.from_matrix(poses[tip][:3, :3] @ target[:3, :3].T).magnitude())
    size = max(case.tree.scale, max(float(np.abs(pose[:3, 3]).max()) for pose in poses.values()))
    if np.sqrt(squared) > given.tolerance + 1e-12 * size or angle > TOLERANCE + ROUNDING:
        return [("false success", f"a success {np.sqrt(squared):.3g} m and {angle:.3g} rad off")]
    return []


def too_near(case: Setup, given: Problem, q: np.ndarray) -> list[tuple[str, str]]:
    """Distances below the safe one, or below where they started, on the way through the rows of q."""
    radii, rounding = np.full(BALLS, 0.3 * case.tree.scale), ROUNDING * case.tree.scale
    rounding += 1e-11 * len(q)
    allowed, worst = np.minimum(case.tree.distances(q[0], given.centers, radii), case.safe), 0.0
    for start, end in itertools.pairwise(q):
        if (start != end).any():
            path = case.tree.between(start, end, np.linspace(0, 1, SAMPLES + 1)[1:])
            worst = max(worst, float((allowed - case.tree.distances(path, given.centers, radii)).max()))
    return [("clearance", f"{worst / case.tree.scale:.3g} links below the safe distance")] if worst > rounding else []


def leaking(case: Setup) -> list[tuple[str, str]]:
    """The largest leakage above its bound of all steps in the log, accepted or not."""
    layout, worst = case.ik._engine.runners.traced_solve.fused.record.slices, (1.0, "")
    for q, record in case.log:
        nu, dq = record[layout["null_space"]], record[layout["dq"]]
        restored = "too_near" in layout and record[layout["too_near"]][0] > 0  # nu then contains the restoration
        if restored or not (np.isfinite(nu).all() and np.isfinite(dq).all() and nu.any()):
            continue
        rows = [case.tree.jacobian(q, tip) for tip, _ in zip(case.tree.tips, case.kinds, strict=False)]
        rows = [
            J if kind == "pose" else J[: case.tree.robot.dimension] for J, kind in zip(rows, case.kinds, strict=True)
        ]
        J = np.vstack(rows)
        length = max(np.linalg.norm(nu), np.linalg.norm(dq), 1.0 if case.clear else 0.0)
        leak = np.linalg.norm(J @ nu) / np.linalg.norm(J) / length
        if leak > LEAKAGE:
            sigma = np.linalg.svd(J[:, nu != 0], compute_uv=False)
            singular = len(sigma) < len(J) or sigma[-1] < SINGULAR_LEAKAGE * np.linalg.norm(J)
            excess = leak / (SINGULAR_LEAKAGE if singular else LEAKAGE)
            if excess > worst[0]:
                taken = "taken" if record[layout["accepted"]][0] else "refused"
                text = f"{leak:.3g} of |J| in a {taken} step of {np.linalg.norm(dq):.3g}, sigma {sigma[-1]:.3g}"
                worst = excess, text
    return [("leakage", worst[1])] if worst[1] else []


def stepped(case: Setup, given: Problem) -> list[tuple[str, str]]:
    """What is wrong with a few steps of a controller, with and without a time, from a start within the limits."""
    tree, target, wrong = case.tree, target_of(case, given), []
    start = np.clip(given.q0, tree.robot.lower, tree.robot.upper) if case.limited else given.q0
    place_obstacles(case, given)
    speed, acceleration = case.speed
    scalar = np.concatenate([[joint.type.is_scalar] * joint.type.nv for joint in tree.own])
    for dt in (None, 0.02, 0.002):
        case.ik.reset()
        q, before = [start], np.zeros(tree.robot.n)
        for _ in range(8):
            q.append(case.ik.step(q[-1], target, dt=dt).q)
            if not np.isfinite(q[-1]).all():
                return [*wrong, ("NaN", f"a step of {dt} s is not finite")]
            if dt is None:
                continue
            velocity = tree.change(q[-2], q[-1]) / dt
            rounding = ROUNDING * np.maximum(1, np.abs(start).max()) / dt
            if (np.abs(velocity) > speed + rounding).any():
                wrong.append(("velocity", f"{np.abs(velocity).max() / speed:.6g} of its limit, step of {dt} s"))
            excess = (np.abs(velocity - before)[scalar]).max(initial=0.0)
            if acceleration and excess > acceleration * dt + 2 * rounding:
                wrong.append(("acceleration", f"{excess / acceleration / dt:.6g} of its limit, step of {dt} s"))
            before = velocity
        if case.limited and tree.outside(np.array(q)) > ROUNDING:
            wrong.append(("limit", f"outside its limits by {tree.outside(np.array(q)):.3g}, step of {dt} s"))
        if case.clear and not (dt and acceleration):
            wrong += [(kind, f"{text}, step of {dt} s") for kind, text in too_near(case, given, np.array(q))]
    return wrong
