"""pyroki as a contender: nonlinear least squares in JAX."""

from __future__ import annotations

import io
import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from jtik.study.contender import Answer, PreparedContender
from jtik.study.peers.base import Goal, Peer, imported
from jtik.types import Array


@dataclass(kw_only=True)
class PyrokiPeer(Peer):
    """Pose cost and limit cost of pyroki, solved by ``jaxls`` in double precision; an attempt is compiled once.

    The defaults are those of pyroki's own benchmark, except the linear solver: jaxls from PyPI has no dense solver in
    double precision. Limits are a cost, so an attempt may end outside them; it then counts as failed. The package on
    PyPI is a fork, almond-pyroki, which installs the module ``pyroki``.

    Attributes:
        label: name of the library in a study.
        position_weight: position weight of the pose cost.
        orientation_weight: orientation weight of the pose cost.
        limit_weight: weight of the limit cost.
        trust: initial lambda of the trust region.
        linear_solver: linear solver of jaxls.
        restarted: maximum steps of an attempt if restarts are allowed.
    """

    label: str = "pyroki"
    position_weight: float = 10.0
    orientation_weight: float = 5.0
    limit_weight: float = 50.0
    trust: float = 10.0
    linear_solver: str = "conjugate_gradient"
    restarted: int = 30
    module: ClassVar[str] = "pyroki"
    package: ClassVar[str] = "almond-pyroki"
    optimizes = False

    def build(self, library: Any, goal: Goal) -> PreparedContender:
        """Build it on the robot as a URDF."""
        return _PreparedPyroki(library, goal, self)


class _PreparedPyroki(PreparedContender):
    """The solver of pyroki."""

    def __init__(self, library: Any, goal: Goal, options: PyrokiPeer) -> None:
        from jtik.interop.urdf import UNLIMITED, to_urdf

        jax = imported("jax", options.package)
        yourdfpy = imported("yourdfpy", options.package)
        self._jax, self._lie, self._goal = jax, imported("jaxlie", options.package), goal
        text = to_urdf(goal.bare, revolute_limit=UNLIMITED).encode()
        urdf = yourdfpy.URDF.load(io.BytesIO(text), build_scene_graph=True, load_meshes=False)
        with jax.enable_x64(True):
            robot = library.Robot.from_urdf(urdf)
            names = list(robot.joints.actuated_names)
            self._places = [names.index(joint.name) for joint in goal.robot.independent_joints]
            self._full = np.zeros(len(names))
            self._attempt = _attempt(library, robot, goal, options)
            with _silent(options.package):
                self._attempt(self._full, np.array(self._lie.SE3.identity().wxyz_xyz))

    def convert(self, target: Any) -> Any:
        """The pose as quaternion (w, x, y, z) and position, (7,)."""
        with self._jax.enable_x64(True):
            return np.array(self._lie.SE3.from_matrix(self._goal.pose(target)).wxyz_xyz)

    def solve(self, target: Any, q0: Array) -> Answer:
        """Run attempts until one succeeds; otherwise return the attempt with the smallest error."""
        goal, taken = self._goal, 0
        best, smallest = np.asarray(q0), math.inf
        with self._jax.enable_x64(True):
            for start in goal.starts(q0):
                self._full[self._places] = start
                found, position, orientation, steps = self._attempt(self._full, target)
                taken += int(steps)
                q = goal.clamped_rounding(np.array(found)[self._places])
                errors = (float(position), float(orientation))
                if goal.is_reached(*errors) and np.array_equal(q, goal.clamped(q)):
                    return Answer(q, "REACHED", True, taken)
                if sum(errors) < smallest:
                    best, smallest = q, sum(errors)
        return Answer(best, "ITERATION_LIMIT", False, taken)


@contextmanager
def _silent(package: str) -> Iterator[None]:
    """Disable the log messages of pyroki and jaxls."""
    logger = imported("loguru", package).logger
    for name in ("pyroki", "jaxls"):
        logger.disable(name)
    try:
        yield
    finally:
        for name in ("pyroki", "jaxls"):
            logger.enable(name)


def _attempt(library: Any, robot: Any, goal: Goal, options: PyrokiPeer) -> Any:
    """(q, target) -> q, position error [m], orientation error [rad], steps; compiled at the first call."""
    jax = imported("jax", options.package)
    jaxlie, jaxls = imported("jaxlie", options.package), imported("jaxls", options.package)
    numbers = jax.numpy
    link = robot.links.names.index(goal.frame)
    max_steps = goal.setting.max_iterations
    if goal.setting.restarts:
        max_steps = min(max_steps, options.restarted)

    def attempt(start: Any, target: Any) -> Any:
        variable, wanted = robot.joint_var_cls(0), jaxlie.SE3(target)
        costs = [
            library.costs.pose_cost_analytic_jac(
                robot,
                variable,
                wanted,
                numbers.array(link, dtype=numbers.int32),
                pos_weight=options.position_weight if goal.has_position else 0.0,
                ori_weight=options.orientation_weight if goal.has_orientation else 0.0,
            ),
            library.costs.limit_cost(robot, variable, weight=options.limit_weight),
        ]
        solution, summary = (
            jaxls.LeastSquaresProblem(costs, [variable])
            .analyze()
            .solve(
                initial_vals=jaxls.VarValues.make([variable.with_value(start)]),
                verbose=False,
                linear_solver=options.linear_solver,
                trust_region=jaxls.TrustRegionConfig(lambda_initial=options.trust),
                termination=jaxls.TerminationConfig(
                    max_iterations=max_steps, gradient_tolerance=1e-10, parameter_tolerance=1e-10
                ),
                return_summary=True,
            )
        )
        q = solution[variable]
        reached = jaxlie.SE3(robot.forward_kinematics(q)[link])
        rotation_error = (wanted.rotation().inverse() @ reached.rotation()).log()
        position = numbers.linalg.norm(reached.translation() - wanted.translation())
        return q, position, numbers.linalg.norm(rotation_error), summary.iterations

    return jax.jit(attempt)
