"""The contract of a strategy: it keeps its state's names, its limits and its claims, and never raises."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from jtik.arguments import flag, positive_integer, positive_number, random_generator
from jtik.registry import strategy_of
from jtik.result.solution import Solution, Status
from jtik.robot import Joint, JointType, Robot
from jtik.solver import InverseKinematics
from jtik.strategy import LocalModel, Shape, State, Strategy, Update
from jtik.task import FrameTask, Task
from jtik.testing.common import moved, posture, require
from jtik.types import Array

RISE = 1e-12
"""Relative rise of V that is rounding of its evaluation."""

EASY_TOLERANCE = 1e-3
"""Error [m] and [rad] to which an easy target must be reached: steepest descent reaches it as well."""

NULL_SPACE_SIGN = "The null-space displacement is added to q: its sign must be that of -(I - J+ J) grad H"
"""What a rise of H points to."""


def check_strategy(
    strategy: str | Strategy,
    *,
    samples: int = 3,
    rng: np.random.Generator | int = 0,
    monotone: bool | None = None,
    tolerance: float = EASY_TOLERANCE,
    max_iterations: int = 5000,
) -> None:
    """Check that a strategy keeps its contract: robots are planar, spatial, mixed and limited, one has joint weights.

    It reaches targets close to the start, with and without a criterion; its displacement has the right sign; with a
    criterion H falls; no iterate is NaN or leaves the joint limits; V never rises where the strategy guarantees it; a
    solve from an exactly straight start, or for a target out of reach, returns a Solution; equal solves have equal
    results; and nothing raises.

    Args:
        strategy: a registered name or a Strategy.
        samples: number of starts on each robot.
        rng: a seed, or a generator.
        monotone: whether V may never rise in an accepted step without a criterion; by default taken from
            ``acceptance()``, and False for a strategy without it.
        tolerance: error to which the targets must be reached [m] and [rad].
        max_iterations: number of steps in which they must be reached.

    Raises:
        AssertionError: when something does not hold; the message contains what and where.
        StrategyError: when a method returns what cannot be used.
        JtikError: when the solver refuses the strategy.
    """
    samples, tolerance = positive_integer("samples", samples), positive_number("tolerance", tolerance)
    max_iterations, generator = positive_integer("max_iterations", max_iterations), random_generator("rng", rng)
    if monotone is not None:
        monotone = flag("monotone", monotone, "whether V never rises in an accepted step; or None")
    checked = strategy_of(strategy)
    claims_monotone = _claims_monotone(checked) if monotone is None else monotone
    for robot, task, weights in _test_cases():
        for criteria in (None, posture):
            ik = InverseKinematics(robot, task, criteria=criteria, strategy=checked, weights=weights)
            where = f"strategy {checked!r} on {robot!r} {'with' if criteria else 'without'} a criterion"
            where += f", with weights={weights}" if weights else ""
            falls = claims_monotone and criteria is None
            for _ in range(samples):
                start = moved(robot, robot.neutral, generator.uniform(-0.6, 0.6, robot.n))
                aim = moved(robot, start, generator.uniform(-0.15, 0.15, robot.n))
                _check_reachable(where, ik, start, robot.pose(aim), tolerance, max_iterations, falls=falls)
                _check_out_of_reach(where, ik, start, falls=falls)
                if criteria and task.row_count(robot) < robot.n:
                    _check_criterion_falls(where, ik, start)
            _check_straight(where, ik, falls=falls)


def _test_cases() -> list[tuple[Robot, Task, dict[str, float] | None]]:
    """Robots, tasks and joint weights that together have all properties that a strategy has to support."""
    half = np.pi / 2
    spatial = [(0.1, half, 0.3), (0.4, 0.3, 0.0), (0.0, -half, 0.1), (0.3, half, 0.3), (0.0, -half, 0.2)]
    spatial += [(0.0, half, 0.0), (0.1, 0.0, 0.1)]
    rows = [
        {"a": a, "alpha": alpha, "d": d, "theta": 0.4 * (-1) ** i, "lower": -1.5, "upper": 1.5}
        for i, (a, alpha, d) in enumerate(spatial)
    ]
    along_x = np.eye(4)
    along_x[0, 3] = 0.5
    tilted = np.array([0.0, 1.0, 0.0])
    ball = Robot(
        [
            Joint("shoulder", JointType.BALL, "base", "upper"),
            Joint("elbow", JointType.REVOLUTE, "upper", "fore", origin=along_x, axis=tilted),
            Joint("wrist", JointType.BALL, "fore", "hand", origin=along_x),
            Joint("tip", JointType.FIXED, "hand", "tip", origin=along_x),
        ],
        name="ball",
    )
    vehicle = Robot.vehicle(3, lower=-2.0, upper=2.0)
    return [
        (Robot.planar(5), FrameTask("tip", "position"), None),
        (Robot.planar(5), FrameTask("tip", "position", axes="x"), None),
        (Robot.planar(5, lower=-0.7, upper=0.7), FrameTask("tip", "position", stiffness=[1.0, 4.0]), None),
        (Robot.planar(4), FrameTask("tip", "pose"), None),
        (vehicle, FrameTask("tip", "position"), {"x": 9.0, "y": 9.0}),
        (Robot.from_dh(rows), FrameTask("tip", "position"), None),
        (Robot.from_dh(rows), FrameTask("tip", "pose", stiffness=[1.0] * 3 + [0.1] * 3), None),
        (ball, FrameTask("tip", "position"), None),
    ]


def _has_unlimited_translation(robot: Robot) -> bool:
    return any(
        not robot.rotational[robot.v_slice(name).start] and np.isinf(robot.upper[robot.q_slice(name).start])
        for name in robot.joint_names
    )


def _claims_monotone(strategy: Strategy) -> bool:
    acceptance = getattr(strategy, "acceptance", None)
    return acceptance is not None and acceptance() != "always"


def _check_solution(where: str, robot: Robot, solution: Solution, *, falls: bool) -> None:
    trace = solution.trace
    assert trace is not None
    start = trace.q[0].tolist()
    require(bool(np.isfinite(trace.q).all()), f"{where} meets an iterate that is not finite from q0 = {start}")
    require(
        solution.status is not Status.NOT_FINITE,
        f"{where} meets a figure that is not finite from q0 = {start}",
    )
    after = trace.q[1:]
    inside = bool((after >= robot.lower).all() and (after <= robot.upper).all())
    require(inside, f"{where} leaves the joint limits from q0 = {start}")
    require(np.array_equal(solution.q, trace.q[-1]), f"{where} does not return its last iterate from q0 = {start}")
    if falls and len(trace):
        V = trace.V
        rise = (V[1:] - V[:-1]) > RISE * V[:-1]
        require(
            not rise.any(),
            f"{where} lets V rise at iterations {np.flatnonzero(rise).tolist()} from q0 = {start}",
        )


def _check_reachable(
    where: str,
    ik: InverseKinematics,
    start: Array,
    target: Array,
    tolerance: float,
    max_iterations: int,
    *,
    falls: bool,
) -> None:
    solutions = [
        ik.solve(
            target,
            q0=start,
            max_iterations=max_iterations,
            position_tolerance=tolerance,
            orientation_tolerance=tolerance,
            until="reached",
            trace=trace,
        )
        for trace in (True, False)
    ]
    solution, again = solutions
    _check_solution(where, ik.robot, solution, falls=falls)
    if not solution.converged:
        _check_sign(where, ik, start, target)
        _check_criterion_sign(where, ik, solution)
    require(
        solution.converged,
        f"{where} does not reach a target within 0.15 rad of q0 = {start.tolist()}: {solution.status.value}",
    )
    require(np.array_equal(again.q, solution.q), f"{where} returns different results for the same arguments")
    ik.reset()
    stepped = ik.step(start, target).q
    require(bool(np.isfinite(stepped).all()), f"a step of {where} returns {stepped}")


def _check_sign(where: str, ik: InverseKinematics, start: Array, target: Array) -> None:
    """A strategy that does not reach a target must not fail because of the sign of its displacement or of its merit."""
    before = ik.solve(target, q0=start, max_iterations=0)
    error = before.position_error + before.orientation_error
    require(
        not _error_after(ik, start, target, sign=-1) < error,
        f"{where} proposes a displacement of the wrong sign from q0 = {start.tolist()}: dq is added to q, and -dq is "
        "what brings the target nearer",
    )
    refused = ik.solve(target, q0=start, max_iterations=50, trace=True).trace
    if refused is not None and len(refused) > 1 and not refused.accepted.any():
        require(
            not _error_after(ik, start, target, sign=1) < error,
            f"{where} does not reach a target and refuses every step from q0 = {start.tolist()}, though its first "
            "displacement brings the target nearer: the sign of the decrease that it predicts, or of its merit "
            "function, may be wrong",
        )


def _error_after(ik: InverseKinematics, start: Array, target: Array, *, sign: int) -> float:
    """Sum of the errors after one displacement of the strategy, multiplied by ``sign`` and taken whatever it brings."""
    taken = InverseKinematics(ik.robot, ik.tasks.tasks, strategy=_Taken(ik.strategy, sign), limits=False)
    after = taken.solve(target, q0=start, max_iterations=1)
    return after.position_error + after.orientation_error


def _check_criterion_sign(where: str, ik: InverseKinematics, solution: Solution) -> None:
    """A strategy that reaches no target beside a criterion must not fail because it raises the criterion."""
    trace = solution.trace
    assert trace is not None
    if not len(trace) or not ik.parameters:
        return
    require(
        not solution.cost > trace.H[0],
        f"{where} does not reach a target, and raises H from {trace.H[0]} to {solution.cost}, from q0 = "
        f"{trace.q[0].tolist()}. {NULL_SPACE_SIGN}",
    )


def _check_criterion_falls(where: str, ik: InverseKinematics, start: Array) -> None:
    """From a start on its target a strategy must lower H."""
    target = ik.robot.pose(start)
    before = ik.solve(target, q0=start, max_iterations=0)
    if before.second_order is not None or before.null_space_residual < 1e-3:
        return
    after = ik.solve(target, q0=start, max_iterations=200)
    require(
        after.cost < before.cost,
        f"{where} does not lower H, {before.cost}, from a start on its target, q0 = {start.tolist()}: it ends at "
        f"{after.cost}. {NULL_SPACE_SIGN}",
    )


class _Taken(Strategy):
    """A strategy whose displacements are multiplied by ``sign``, and all taken."""

    def __init__(self, strategy: Strategy, sign: int) -> None:
        self._strategy, self._sign = strategy, sign

    def __repr__(self) -> str:
        return repr(self._strategy)

    def uses_qp(self, has_criterion: bool) -> bool:
        """As the strategy."""
        return self._strategy.uses_qp(has_criterion)

    def initial_state(self, shape: Shape) -> Mapping[str, Array]:
        """As the strategy."""
        return self._strategy.initial_state(shape)

    def update(self, model: LocalModel, state: State) -> Update:
        """The displacement of the strategy, with the sign."""
        return Update(self._sign * self._strategy.update(model, state).dq)


def _check_out_of_reach(where: str, ik: InverseKinematics, start: Array, *, falls: bool) -> None:
    """A target a kilometre away is not reached, unless the robot can drive there."""
    if _has_unlimited_translation(ik.robot):
        return
    away = ik.robot.pose(start)
    away[:2, 3] += 1e3
    solution = ik.solve(away, q0=start, max_iterations=200, trace=True)
    _check_solution(where, ik.robot, solution, falls=falls)
    require(not solution.converged, f"{where} claims to reach a target a kilometre away: {solution!r}")


def _check_straight(where: str, ik: InverseKinematics, *, falls: bool) -> None:
    """From the neutral configuration, for many robots a singular one, halfway in towards the base."""
    robot = ik.robot
    inward = robot.pose(robot.neutral)
    inward[: robot.dimension, 3] *= 0.5
    solution = ik.solve(inward, q0=robot.neutral, max_iterations=500, trace=True)
    _check_solution(f"{where}, singular start", robot, solution, falls=falls)
