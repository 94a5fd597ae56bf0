"""The contract of a criterion: scalar, finite, with a correct gradient and live parameters."""

from __future__ import annotations

import inspect
import pickle
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jtik.arguments import instance, integer, random_generator, several
from jtik.criterion import Criterion, CriterionTerms, ResidualCriterion
from jtik.errors import ArgumentError
from jtik.geometry import Circle, Sphere
from jtik.result.solution import Status
from jtik.robot import Robot
from jtik.solver import InverseKinematics
from jtik.symbolic import function, gradient, jacobian, symbol, symvar
from jtik.symbolic.compile import CompiledFunction
from jtik.task import FrameTask
from jtik.testing.common import require
from jtik.testing.configurations import configurations
from jtik.testing.criterion_derivatives import check_gradient, check_hessian
from jtik.testing.own_gradient import check_own_gradient, own_gradient
from jtik.testing.residual_form import check_residual_form
from jtik.types import Array

SECOND_DERIVATIVES = 8
"""Number of configurations at which second derivatives are checked: those where a criterion may fail, and some more."""


def check_criterion(
    criterion: Criterion,
    robot: Robot,
    *,
    samples: int | Iterable[ArrayLike] = 20,
    rng: np.random.Generator | int = 0,
) -> None:
    """Check that a criterion fulfils what a solver assumes, on one robot.

    - It has a name, and parameters that are the same at every call.
    - It is one scalar expression of q and of these parameters, and it depends on each of them.
    - It and its gradient are finite at every sample, and the same at every evaluation.
    - The gradient agrees with central differences, and the second derivatives with differences of the gradient.
    - Its `jtik.Criterion.value_and_gradient`, where it has one, agrees with both.
    - In residual form (`jtik.criterion.ResidualCriterion`) H is 1/2 |r|^2, and the Jacobian of r is finite and agrees
      with the gradient, A' r.
    - Where it can be found by name, it can be pickled, and has the same value afterwards.
    - A solve with it ends, does not raise H on a target already reached, and doubles H with the weight.

    Args:
        criterion: the criterion.
        robot: a robot it is meant for.
        samples: number of random configurations, besides those where a criterion may fail (the neutral one, singular
            ones, ones at the limits); or the configurations (nq,) themselves.
        rng: a seed, or a generator.

    Raises:
        AssertionError: when the criterion violates the contract; the message contains how, and at which q.
        JtikError: when the solver refuses the criterion.
    """
    instance("robot", robot, Robot, "a jtik.Robot")
    generator = random_generator("rng", rng)
    if not isinstance(samples, int) or isinstance(samples, bool):
        samples = several("samples", samples, "a number of configurations, or configurations (nq,)")
    else:
        samples = integer("samples", samples)
    who = f"criterion {getattr(criterion, 'name', criterion)!r}"
    require(isinstance(criterion, Criterion), f"{who} must be a jtik.Criterion, not {type(criterion).__name__}")
    require(isinstance(getattr(criterion, "name", None), str) and bool(criterion.name), f"{who} must have a name")
    _check_parameters(who, criterion, robot)
    terms = CriterionTerms.of(robot, criterion)
    q, parameters = symbol("q", robot.nq), terms.parameters.symbols()
    (H,) = terms.values(robot.at(q), parameters)
    read = {variable.name() for variable in symvar(H)}
    for name in terms.parameters:
        own = {variable.name() for variable in symvar(terms.parameters.take(parameters, name))}
        require(
            not own or bool(own & read),
            f"{who} never reads its parameter {name!r}; use the expression in `parameters`, not its first value",
        )
    along = robot.tangent(q).T @ gradient(H, q)
    evaluate = CompiledFunction(function("criterion", [q, parameters], [H, along]))
    second = jacobian(along, q) @ robot.tangent(q)
    curvature = CompiledFunction(function("curvature", [q, parameters], [second]))
    memory, first_order = terms.parameters.memory, own_gradient(terms)

    def value_at(at: Array) -> float:
        return float(evaluate(at, memory)[0][0, 0])

    def gradient_at(at: Array) -> Array:
        return evaluate(at, memory)[1][:, 0].copy()

    for k, sample in enumerate(configurations(robot, samples, generator)):
        value, analytic = (result[:, 0].copy() for result in evaluate(sample, memory))
        require(np.isfinite(value[0]), f"{who} is {value[0]} at q = {sample.tolist()}, not finite")
        require(bool(np.isfinite(analytic).all()), f"the gradient of {who} is {analytic} at q = {sample.tolist()}")
        require(
            evaluate(sample, memory)[0][0, 0] == value[0],
            f"{who} has different values in two evaluations at q = {sample.tolist()}",
        )
        check_gradient(who, robot, sample, analytic, value_at)
        if first_order is not None:
            check_own_gradient(who, sample, value[0], analytic, first_order(sample, memory))
        if k < SECOND_DERIVATIVES:
            check_hessian(who, robot, sample, curvature(sample, memory)[0].copy(), gradient_at)
        if isinstance(criterion, ResidualCriterion):
            check_residual_form(who, terms, sample, value[0], analytic)
    _check_pickle(who, criterion, robot, generator)
    _check_use(who, criterion, robot, generator)


def example_criterion(plugin: type[Criterion], robot: Robot) -> Criterion:
    """An object of a criterion class, to test a registered class on ``robot``.

    A class whose arguments have no defaults needs a classmethod ``example(robot)``. The argument ``obstacles`` alone
    needs none: it gets two circles or spheres.

    Args:
        plugin: the class.
        robot: the robot that the object is for.

    Raises:
        ArgumentError: when an argument has no default and the class has no ``example``.
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


def _obstacles(robot: Robot) -> list[Circle | Sphere]:
    if robot.dimension == 2:
        return [Circle(center=(2.5, 1.5), radius=0.4), Circle(center=(-1.0, 2.0), radius=0.2)]
    return [Sphere(center=(0.9, 0.4, 0.3), radius=0.1), Sphere(center=(-0.4, 0.2, 0.9), radius=0.2)]


def _check_parameters(who: str, criterion: Criterion, robot: Robot) -> None:
    first, second = criterion.parameters(robot), criterion.parameters(robot)
    require(isinstance(first, Mapping), f"the parameters of {who} must be a mapping, not {type(first).__name__}")
    require(
        list(first) == list(second),
        f"the parameters of {who} change their names: {list(first)}, {list(second)}",
    )
    for name, value in first.items():
        require(
            isinstance(name, str) and name != "weight",
            f"{who} must not name a parameter {name!r}; accepted: any text but 'weight'",
        )
        array, again = np.asarray(value, dtype=float), np.asarray(second[name], dtype=float)
        require(
            array.ndim <= 2,
            f"parameter {name!r} of {who} must be a scalar, vector or matrix, not {array.ndim}-D",
        )
        require(bool(np.isfinite(array).all()), f"parameter {name!r} of {who} starts at {array}, not finite")
        require(np.array_equal(array, again), f"parameter {name!r} of {who} starts at {array} and at {again}")


def _check_pickle(who: str, criterion: Criterion, robot: Robot, generator: np.random.Generator) -> None:
    """It can be pickled, unless Python cannot find it: a local function or class, or one of a notebook."""
    made = getattr(criterion, "_function", type(criterion))
    if made.__module__ in (None, "__main__", "builtins") or "<locals>" in made.__qualname__:
        return
    try:
        again = pickle.loads(pickle.dumps(criterion))
    except Exception as error:
        raise AssertionError(f"{who} cannot be pickled: {type(error).__name__}: {error}") from error
    q = robot.random_configuration(generator)
    before, after = criterion(q, robot), again(q, robot)
    require(before == after, f"{who} is {before} and, after it was pickled, {after}, at q = {q.tolist()}")


def _check_use(who: str, criterion: Criterion, robot: Robot, generator: np.random.Generator) -> None:
    """A solve with it ends, does not raise H on a target already reached, and doubles H with the weight."""
    start = robot.random_configuration(generator)
    ik = InverseKinematics(robot, FrameTask(robot.tip), criteria=criterion)
    solution = ik.solve(robot.pose(start), q0=start, max_iterations=200)
    require(bool(np.isfinite(solution.q).all()), f"a solve with {who} ends at q = {solution.q}")
    require(solution.status is not Status.NOT_FINITE, f"a solve with {who} ended at a value that is not finite")
    before = ik.solve(robot.pose(start), q0=start, max_iterations=0).cost
    require(
        solution.cost <= before + 1e-6 * max(1.0, abs(before)),
        f"a solve that starts on the target raises {who} from {before} to {solution.cost}",
    )
    weight = f"{criterion.name}.weight"
    ik.parameters[weight] = 2.0
    doubled = ik.solve(robot.pose(start), q0=start, max_iterations=0).cost
    require(
        abs(doubled - 2 * before) <= 1e-9 * max(1.0, abs(before)),
        f"{who} is {before} at weight 1 and {doubled} at weight 2",
    )
