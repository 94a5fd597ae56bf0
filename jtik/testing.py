"""The contract every criterion and every strategy must meet, ours and those of third parties.

Call `check_criterion` and `check_strategy` in the tests of a plugin; what does not hold raises an AssertionError that
says what was expected, or the JtikError that a user would have met.
"""

from __future__ import annotations

import inspect
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jtik.compile import Compiled
from jtik.criterion import Criterion, CriterionTerms, criterion
from jtik.errors import ArgumentError
from jtik.geometry import Circle, Sphere
from jtik.registry import strategy_of
from jtik.robot import Joint, JointType, Robot
from jtik.solution import Solution, Status
from jtik.solver import InverseKinematics
from jtik.strategy import LocalModel, Shape, State, Strategy, Update
from jtik.symbolic import Expression, function, gradient, sumsqr, symbol, symvar
from jtik.task import FrameTask, Task

Array = NDArray[np.float64]

DIFFERENCE_STEPS = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7)
"""Steps of the central differences [rad] or [m]: a right gradient agrees at one of them, however stiff H is."""

DIFFERENCE_TOLERANCE = 1e-4
"""Relative disagreement allowed between a gradient and its best central difference."""

RISE = 1e-12
"""Relative rise of V that is rounding of its evaluation."""

EASY_TOLERANCE = 1e-3
"""Error [m] and [rad] to which an easy target must be reached: steepest descent gets there, too."""


def check_criterion(
    criterion: Criterion,
    robot: Robot,
    *,
    samples: int | Iterable[ArrayLike] = 20,
    rng: np.random.Generator | int = 0,
) -> None:
    """Check that a criterion is what a solver takes it for, on one robot.

    It has a name and parameters that are the same whenever asked for; it is one scalar expression of q and of
    these parameters, each of which it really reads, so that changing one acts at once; it and its gradient are
    finite at every sample; the gradient agrees with central differences; and a solve with it ends.

    Args:
        criterion: the criterion.
        robot: a robot it is meant for.
        samples: how many random configurations to look at besides the neutral one, or these configurations (nq,).
        rng: a seed, or a generator.

    Raises:
        AssertionError: when something does not hold; the message says what and where.
        JtikError: when the solver refuses the criterion.
    """
    who = f"criterion {getattr(criterion, 'name', criterion)!r}"
    _require(isinstance(criterion, Criterion), f"{who} must be a jtik.Criterion, not {type(criterion).__name__}")
    _require(isinstance(getattr(criterion, "name", None), str) and bool(criterion.name), f"{who} must have a name")
    _check_parameters(who, criterion, robot)
    generator = np.random.default_rng(rng)
    terms = CriterionTerms.of(robot, criterion)
    q, parameters = symbol("q", robot.nq), terms.parameters.symbols()
    (H,) = terms.values(robot.at(q), parameters)
    read = {variable.name() for variable in symvar(H)}
    for name in terms.parameters:
        own = {variable.name() for variable in symvar(terms.parameters.take(parameters, name))}
        _require(
            not own or bool(own & read),
            f"{who} never reads its parameter {name!r}; use the expression it is given, not the number it began with",
        )
    slope = robot.tangent(q).T @ gradient(H, q)
    evaluate = Compiled(function("criterion", [q, parameters], [H, slope]))
    memory = terms.parameters.memory
    for sample in _samples(robot, samples, generator):
        value, analytic = (result[:, 0] for result in evaluate(sample, memory))
        _require(np.isfinite(value[0]), f"{who} is {value[0]} at q = {sample.tolist()}, not finite")
        _require(bool(np.isfinite(analytic).all()), f"the gradient of {who} is {analytic} at q = {sample.tolist()}")
        _require(
            evaluate(sample, memory)[0][0, 0] == value[0],
            f"{who} is not the same twice at q = {sample.tolist()}",
        )
        _check_gradient(who, robot, sample, analytic, lambda at: float(evaluate(at, memory)[0][0, 0]))
    _check_use(who, criterion, robot, generator)


def check_strategy(
    strategy: str | Strategy,
    *,
    samples: int = 3,
    rng: np.random.Generator | int = 0,
    monotone: bool | None = None,
    tolerance: float = EASY_TOLERANCE,
    max_iterations: int = 5000,
) -> None:
    """Check that a strategy is what the loop takes it for, on planar, spatial, mixed and limited robots.

    Its state keeps its names and sizes from one update to the next, its step and its figures have the right
    shapes; it reaches near targets, with and without a criterion; no iterate is NaN or leaves the joint limits;
    V never rises where it says so; a target out of reach and an exactly straight start end in a Solution; the
    same question has the same answer; and nothing raises.

    Args:
        strategy: a registered name or a Strategy.
        samples: starts on each robot.
        rng: a seed, or a generator.
        monotone: whether V may never rise in an accepted step without a criterion; by default what ``acceptance()``
            of a Composition says, and no claim for any other strategy.
        tolerance: error [m] and [rad] to which near targets must be reached.
        max_iterations: in how many steps.

    Raises:
        AssertionError: when something does not hold; the message says what and where.
        JtikError: when the solver refuses the strategy.
    """
    law = strategy_of(strategy)
    claims_monotone = _claims_monotone(law) if monotone is None else monotone
    generator = np.random.default_rng(rng)
    for robot, task in _benches():
        for criteria in (None, _posture):
            watched = _Watched(law)
            ik = InverseKinematics(robot, task, criteria=criteria, strategy=watched)
            where = f"strategy {law!r} on {robot!r} {'with' if criteria else 'without'} a criterion"
            falls = claims_monotone and criteria is None
            for _ in range(samples):
                start = _moved(robot, robot.neutral, generator.uniform(-0.6, 0.6, robot.n))
                aim = _moved(robot, start, generator.uniform(-0.15, 0.15, robot.n))
                _check_near(where, ik, start, robot.pose(aim), tolerance, max_iterations, falls=falls)
                _check_far(where, ik, start, falls=falls)
            _check_straight(where, ik, falls=falls)


def example_criterion(plugin: type[Criterion], robot: Robot) -> Criterion:
    """An object of a criterion class, to put a registered class to the test on ``robot``.

    A class whose arguments have no defaults offers a classmethod ``example(robot)``; the argument ``obstacles``
    is known.

    Raises:
        ArgumentError: when nothing says how to make one.
    """
    offered = getattr(plugin, "example", None)
    if offered is not None:
        made: Criterion = offered(robot)
        return made
    required = [
        name
        for name, parameter in inspect.signature(plugin).parameters.items()
        if parameter.default is parameter.empty
        and parameter.kind not in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD)
    ]
    known: dict[str, Any] = {"obstacles": _obstacles(robot)}
    unknown = [name for name in required if name not in known]
    if unknown:
        raise ArgumentError(
            plugin.__name__,
            f"arguments without a default: {unknown}",
            "defaults for all arguments, or a classmethod example(robot)",
        )
    return plugin(**{name: known[name] for name in required})


def _require(condition: bool | np.bool_, message: str) -> None:
    if not condition:
        raise AssertionError(message)


def _obstacles(robot: Robot) -> list[Circle | Sphere]:
    if robot.dimension == 2:
        return [Circle(center=(2.5, 1.5), radius=0.4), Circle(center=(-1.0, 2.0), radius=0.2)]
    return [Sphere(center=(0.9, 0.4, 0.3), radius=0.1), Sphere(center=(-0.4, 0.2, 0.9), radius=0.2)]


def _check_parameters(who: str, criterion: Criterion, robot: Robot) -> None:
    first, second = criterion.parameters(robot), criterion.parameters(robot)
    _require(isinstance(first, Mapping), f"the parameters of {who} must be a mapping, not {type(first).__name__}")
    _require(
        list(first) == list(second),
        f"the parameters of {who} change their names: {list(first)}, {list(second)}",
    )
    for name, value in first.items():
        _require(isinstance(name, str) and name != "weight", f"{who} may not call a parameter {name!r}")
        array, again = np.asarray(value, dtype=float), np.asarray(second[name], dtype=float)
        _require(
            array.ndim <= 2,
            f"parameter {name!r} of {who} must be a scalar, vector or matrix, not {array.ndim}-D",
        )
        _require(bool(np.isfinite(array).all()), f"parameter {name!r} of {who} starts at {array}, not finite")
        _require(np.array_equal(array, again), f"parameter {name!r} of {who} starts at {array} and at {again}")


def _samples(robot: Robot, samples: int | Iterable[ArrayLike], generator: np.random.Generator) -> list[Array]:
    if not isinstance(samples, int):
        return [np.array(sample, dtype=float) for sample in samples]
    return [robot.neutral, *[robot.random_configuration(generator) for _ in range(samples)]]


def _check_gradient(who: str, robot: Robot, q: Array, analytic: Array, value: Any) -> None:
    scale = max(1.0, float(np.abs(analytic).max()))
    for j, unit in enumerate(np.eye(robot.n)):
        found = []
        for step in DIFFERENCE_STEPS:
            ahead, behind = robot.integrate(q, step * unit), robot.integrate(q, -step * unit)
            found.append((value(ahead) - value(behind)) / (2 * step))
        finite = [number for number in found if np.isfinite(number)]
        best = min(finite, key=lambda number: abs(number - analytic[j]), default=np.nan)
        _require(
            abs(best - analytic[j]) <= DIFFERENCE_TOLERANCE * scale,
            f"gradient of {who} along velocity {j} is {analytic[j]}, by differences {best}, at q = {q.tolist()}",
        )


def _check_use(who: str, criterion: Criterion, robot: Robot, generator: np.random.Generator) -> None:
    """A solve with it ends, does not raise H on a target already reached, and sees its parameters change."""
    start = robot.random_configuration(generator)
    ik = InverseKinematics(robot, FrameTask(robot.tip), criteria=criterion)
    solution = ik.solve(robot.pose(start), q0=start, max_iterations=200)
    _require(bool(np.isfinite(solution.q).all()), f"a solve with {who} ends at q = {solution.q}")
    _require(solution.status is not Status.NOT_FINITE, f"a solve with {who} met a value that is not finite")
    before = ik.solve(robot.pose(start), q0=start, max_iterations=0).cost
    _require(
        solution.cost <= before + 1e-6 * max(1.0, abs(before)),
        f"a solve that starts on the target raises {who} from {before} to {solution.cost}",
    )
    weight = f"{criterion.name}.weight"
    ik.parameters[weight] = 2.0
    doubled = ik.solve(robot.pose(start), q0=start, max_iterations=0).cost
    _require(
        abs(doubled - 2 * before) <= 1e-9 * max(1.0, abs(before)),
        f"{who} is {before} at weight 1 and {doubled} at weight 2",
    )


@criterion
def _posture(q: Expression, robot: Robot, *, preferred: float = 0.2) -> Expression:
    """1/2 |q - preferred|^2 over the hinges and slides."""
    return sumsqr(q[[int(i) for i in robot.scalar_q]] - preferred) / 2


def _benches() -> list[tuple[Robot, Task]]:
    """Robots and tasks that between them have every property a law could stumble over."""
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
            Joint("elbow", JointType.HINGE, "upper", "fore", origin=along_x, axis=tilted),
            Joint("wrist", JointType.BALL, "fore", "hand", origin=along_x),
            Joint("tip", JointType.FIXED, "hand", "tip", origin=along_x),
        ],
        name="ball",
    )
    return [
        (Robot.planar(5), FrameTask("tip", "position")),
        (Robot.planar(5), FrameTask("tip", "position", axes="x")),
        (Robot.planar(5, lower=-0.7, upper=0.7), FrameTask("tip", "position", stiffness=[1.0, 4.0])),
        (Robot.planar(4), FrameTask("tip", "pose")),
        (Robot.vehicle(3, lower=-2.0, upper=2.0), FrameTask("tip", "position")),
        (Robot.from_dh(rows), FrameTask("tip", "position")),
        (Robot.from_dh(rows), FrameTask("tip", "pose", stiffness=[1.0] * 3 + [0.1] * 3)),
        (ball, FrameTask("tip", "position")),
    ]


def _can_travel(robot: Robot) -> bool:
    return any(
        not robot.rotational[robot.v_slice(name).start] and np.isinf(robot.upper[robot.q_slice(name).start])
        for name in robot.joint_names
    )


def _moved(robot: Robot, q: Array, dq: Array) -> Array:
    moved: Array = np.clip(robot.integrate(q, dq), robot.lower, robot.upper)
    return moved


def _claims_monotone(strategy: Strategy) -> bool:
    acceptance = getattr(strategy, "acceptance", None)
    return acceptance is not None and acceptance() != "always"


def _check_solution(where: str, robot: Robot, solution: Solution, *, falls: bool) -> None:
    trace = solution.trace
    assert trace is not None
    start = trace.q[0].tolist()
    _require(bool(np.isfinite(trace.q).all()), f"{where} meets an iterate that is not finite from q0 = {start}")
    _require(
        solution.status is not Status.NOT_FINITE,
        f"{where} meets a figure that is not finite from q0 = {start}",
    )
    after = trace.q[1:]
    inside = bool((after >= robot.lower).all() and (after <= robot.upper).all())
    _require(inside, f"{where} leaves the joint limits from q0 = {start}")
    _require(np.array_equal(solution.q, trace.q[-1]), f"{where} does not return its last iterate from q0 = {start}")
    if falls and len(trace):
        V = trace.V
        rise = (V[1:] - V[:-1]) > RISE * V[:-1]
        _require(
            not rise.any(),
            f"{where} lets V rise at iterations {np.flatnonzero(rise).tolist()} from q0 = {start}",
        )


def _check_near(
    where: str,
    ik: InverseKinematics,
    start: Array,
    target: Array,
    tolerance: float,
    max_iterations: int,
    *,
    falls: bool,
) -> None:
    answers = [
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
    solution, again = answers
    _check_solution(where, ik.robot, solution, falls=falls)
    _require(
        solution.converged,
        f"{where} does not reach a target within 0.15 rad of q0 = {start.tolist()}: {solution.status.value}",
    )
    _require(np.array_equal(again.q, solution.q), f"{where} answers the same question differently")
    ik.reset()
    stepped = ik.step(start, target).q
    _require(bool(np.isfinite(stepped).all()), f"a step of {where} arrives at {stepped}")


def _check_far(where: str, ik: InverseKinematics, start: Array, *, falls: bool) -> None:
    """A kilometre away, unless the robot can drive there."""
    if _can_travel(ik.robot):
        return
    away = ik.robot.pose(start)
    away[:2, 3] += 1e3
    lost = ik.solve(away, q0=start, max_iterations=200, trace=True)
    _check_solution(where, ik.robot, lost, falls=falls)
    _require(not lost.converged, f"{where} claims to reach a target a kilometre away: {lost!r}")


def _check_straight(where: str, ik: InverseKinematics, *, falls: bool) -> None:
    """From the neutral configuration, for many robots a singular one, halfway in towards the base."""
    robot = ik.robot
    inward = robot.pose(robot.neutral)
    inward[: robot.dimension, 3] *= 0.5
    solution = ik.solve(inward, q0=robot.neutral, max_iterations=500, trace=True)
    _check_solution(f"{where}, singular start", robot, solution, falls=falls)


class _Watched(Strategy):
    """A strategy as it is, whose state and updates are looked at while they are built."""

    def __init__(self, strategy: Strategy) -> None:
        self._strategy = strategy
        self._who = f"strategy {strategy!r}"

    def __repr__(self) -> str:
        return repr(self._strategy)

    def initial_state(self, shape: Shape) -> Mapping[str, Array]:
        """That of the strategy, checked."""
        state = self._strategy.initial_state(shape)
        for name, value in state.items():
            array = np.asarray(value, dtype=float)
            _require(
                array.ndim == 1 and bool(np.isfinite(array).all()),
                f"{self._who}: state {name!r} must start as a finite one-dimensional array, not {value!r}",
            )
        return state

    def update(self, model: LocalModel, state: State) -> Update:
        """That of the strategy, checked."""
        update = self._strategy.update(model, state)
        _require(
            isinstance(update, Update),
            f"{self._who}: update must return an Update, not {type(update).__name__}",
        )
        before = {name: _rows(value) for name, value in state.items()}
        after = {name: _rows(value) for name, value in update.state.items()}
        _require(
            before == after,
            f"{self._who}: the state begins with names and sizes {before} and after an update has {after}",
        )
        n = model.robot.n
        for name in ("term", "null_term"):
            rows = _rows(getattr(update, name))
            _require(rows == n, f"{self._who}: {name} must have shape ({n}, 1), not ({rows}, 1)")
        _require(
            _rows(update.point.q) == model.robot.nq,
            f"{self._who}: point.q must have shape ({model.robot.nq}, 1)",
        )
        _require(_rows(update.accepted) == 1, f"{self._who}: accepted must be a scalar, 0 or 1")
        for name, figure in update.figures.items():
            _require(_rows(figure) == 1, f"{self._who}: figure {name!r} must be a scalar")
        return update


def _rows(value: Expression) -> int:
    return int(np.prod(getattr(value, "shape", (1, 1))))


__all__ = ["check_criterion", "check_strategy", "example_criterion"]
