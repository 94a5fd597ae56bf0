"""Solvers of each library for one arm: built once, then called with a target (4, 4) for a configuration or None.

Other libraries are set up as in their documentation, with options that a small search found fast over all arms. Each
docstring lists the options that were tried. Restarts are drawn within the limits.
"""

from __future__ import annotations

import importlib
import math
import os
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from ik_arms import Arm

Array = np.ndarray
RESTARTS = 100
"""Maximum number of restarts of a solver."""


@dataclass(frozen=True)
class Accuracy:
    """Tolerances of an answer.

    Attributes:
        position: norm of the position error [m].
        orientation: norm of the orientation error [rad].
    """

    position: float
    orientation: float


@dataclass(frozen=True)
class PreparedSolver:
    """A solver built for an arm.

    Attributes:
        solve: a converted target -> a configuration (n,), or None for no answer; timed.
        convert: a target (4, 4) -> the target in the library's form; not timed.
        batch: many converted targets -> a configuration for each; used instead of ``solve`` if given.
    """

    solve: Callable[[Any], Array | None]
    convert: Callable[[Array], Any] = lambda target: target
    batch: Callable[[Sequence[Any]], Sequence[Array | None]] | None = None


Builder = Callable[[Arm, Accuracy], PreparedSolver]


def _jtik(arm: Arm, accuracy: Accuracy, strategy: Any, *, compiled: bool, batch: bool = False) -> PreparedSolver:
    import jtik

    robot = jtik.Robot.from_urdf(arm.path, tip=arm.tip)
    # a quarter of a metre has the weight of one radian
    task = jtik.FrameTask(arm.tip, kind="pose", stiffness=[1, 1, 1, 0.06, 0.06, 0.06])
    joints = [link.name for link in arm.links]
    ik = jtik.InverseKinematics(robot, task, strategy=strategy, joints=joints, at=np.zeros(robot.nq), compiled=compiled)
    if list(ik.robot.joint_names) != joints:
        raise RuntimeError(f"unexpected joint order: {ik.robot.joint_names}")
    q0 = arm.middle()
    options: dict[str, Any] = {
        "q0": q0,
        "restarts": RESTARTS,
        "position_tolerance": accuracy.position,
        "orientation_tolerance": accuracy.orientation,
        "until": "reached",
    }

    def solve(target: Array) -> Array | None:
        solution = ik.solve(target, **options)
        return solution.q if solution.converged else None

    def many(targets: Sequence[Array]) -> Sequence[Array | None]:
        solutions = ik.solve_batch(targets, **options)
        return [q if good else None for q, good in zip(solutions.q, solutions.converged, strict=True)]

    return PreparedSolver(solve, batch=many if batch else None)


def _damped() -> Any:
    from jtik_formulations import Damped

    return Damped(backtracking=False)


def jtik_damped(arm: Arm, accuracy: Accuracy) -> PreparedSolver:
    """The damped strategy without backtracking, for any solution, as generated C."""
    return _jtik(arm, accuracy, _damped(), compiled=True)


def jtik_batch(arm: Arm, accuracy: Accuracy) -> PreparedSolver:
    """The same by ``solve_batch``."""
    return _jtik(arm, accuracy, _damped(), compiled=True, batch=True)


def jtik_machine(arm: Arm, accuracy: Accuracy) -> PreparedSolver:
    """The same on CasADi's virtual machine, for which no C compiler is needed."""
    return _jtik(arm, accuracy, _damped(), compiled=False)


def jtik_hybrid(arm: Arm, accuracy: Accuracy) -> PreparedSolver:
    """The default strategy, as generated C."""
    return _jtik(arm, accuracy, "hybrid", compiled=True)


def toolbox(
    arm: Arm, accuracy: Accuracy, *, method: str = "chan", k: float = 0.1, ilimit: int = 30, weight: float = 1.0
) -> PreparedSolver:
    """Levenberg-Marquardt of the Robotics Toolbox in C++, on a chain without unnecessary constants.

    Tried: Chan with k = 1 to 0.01, Sugihara with 0.1 to 0.0001, Wampler with 0.01 to 0.0001, 12 to 30 iterations for
    each start, orientation weights 1 to 0.1. It wraps joints without limits to (-pi, pi).
    """
    from roboticstoolbox import ET, ETS

    parts, left = [], np.eye(4)
    for link, lower, upper in zip(arm.links, *arm.bounds(), strict=True):
        to_axis = _axis_to_z(link.axis)
        parts += [ET.SE3(left @ link.placement @ to_axis), ET.Rz(qlim=[lower, upper])]
        left = to_axis.T
    ets = ETS([*parts, ET.SE3(left @ arm.tool)])
    q0 = arm.middle()
    mask = np.array([1.0, 1.0, 1.0, weight, weight, weight])
    # its error is half the weighted sum of squares of all six rows
    tolerance = 0.5 * min(accuracy.position**2, weight * accuracy.orientation**2)

    def solve(target: Array) -> Array | None:
        solution = ets.ik_LM(
            target, q0=q0, ilimit=ilimit, slimit=RESTARTS, tol=tolerance, mask=mask, k=k, method=method
        )
        return solution.q if solution.success else None

    return PreparedSolver(solve)


def _axis_to_z(axis: Array) -> Array:
    """A rotation (4, 4) whose third column is the axis."""
    other = np.eye(3)[int(np.argmin(np.abs(axis)))]
    x = np.cross(other, axis)
    x /= np.linalg.norm(x)
    T = np.eye(4)
    T[:3, :3] = np.column_stack([x, np.cross(axis, x), axis])
    return T


def optik(
    arm: Arm, accuracy: Accuracy, *, turn: float = 2 * math.pi, threads: int = 0, weight: float = 0.5
) -> PreparedSolver:
    """optik in its speed mode, for up to one second, on half of the cores, as its README recommends.

    It takes limits and targets as lists. Tried: pi and 2 pi for joints without limits, one and two threads, orientation
    weights 1, 0.5 and 0.25.
    """
    import optik as library

    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "chain.urdf"
        file.write_text(arm.urdf(turn=turn), encoding="utf-8")
        robot = library.Robot.from_urdf_file(str(file), "base", "tip")
    robot.set_parallelism(threads or max(1, (os.cpu_count() or 2) // 2))
    config = library.SolverConfig(
        solution_mode="speed",
        max_time=1.0,
        tol_f=min(accuracy.position**2, weight**2 * accuracy.orientation**2),
        angular_weight=[weight] * 3,
    )
    q0 = arm.middle().tolist()

    def solve(target: list[list[float]]) -> Array | None:
        found = robot.ik(config, target, q0)
        return None if found is None else np.array(found[0])

    return PreparedSolver(solve, convert=lambda target: target.tolist())


def mink(
    arm: Arm, accuracy: Accuracy, *, calls: int = 15, damping: float = 0.1, cost: float = 0.25, gain: float = 0.999
) -> PreparedSolver:
    """A loop over ``mink.solve_ik`` with DAQP and position limits.

    Tried: 10 to 25 calls for each start, ``lm_damping`` 0 to 0.1, orientation costs 1 and 0.25, gains 0.95 and 0.999.
    """
    import mink as library
    import mujoco

    model = mujoco.MjModel.from_xml_string(arm.urdf())
    configuration = library.Configuration(model)
    task = library.FrameTask("tip", "body", position_cost=1.0, orientation_cost=cost, lm_damping=damping)
    limits = [library.ConfigurationLimit(model, gain=gain)]
    middle, draw = arm.middle(), _draws(arm)

    def solve(target: Any) -> Array | None:
        task.set_target(target)
        for attempt in range(RESTARTS + 1):
            configuration.update(middle if attempt == 0 else draw())
            for _ in range(calls):
                error = task.compute_error(configuration)
                if _small(error, accuracy):
                    return configuration.q
                try:
                    velocity = library.solve_ik(configuration, [task], 1.0, "daqp", limits=limits)
                except library.NoSolutionFound:
                    break
                configuration.integrate_inplace(velocity, 1.0)
            if _small(task.compute_error(configuration), accuracy):
                return configuration.q
        return None

    return PreparedSolver(solve, convert=library.SE3.from_matrix)


def pink(
    arm: Arm, accuracy: Accuracy, *, calls: int = 15, damping: float = 0.1, cost: float = 0.25, gain: float = 0.999
) -> PreparedSolver:
    """A loop over ``pink.solve_ik`` with DAQP and position limits, with the options of mink."""
    import pink as library
    import pinocchio as pin

    model = pin.buildModelFromXML(arm.urdf())
    limits = [library.limits.ConfigurationLimit(model, config_limit_gain=gain)]
    configuration = library.Configuration(model, model.createData(), pin.neutral(model))
    task = library.FrameTask("tip", position_cost=1.0, orientation_cost=cost, lm_damping=damping)
    turning = np.array([link.continuous for link in arm.links])
    places = np.array([joint.idx_q for joint in list(model.joints)[1:]])

    def full(q: Array) -> Array:
        values = np.zeros(model.nq)
        values[places] = np.where(turning, np.cos(q), q)
        values[places[turning] + 1] = np.sin(q[turning])
        return values

    def plain(values: Array) -> Array:
        q = values[places]
        q[turning] = np.arctan2(values[places[turning] + 1], values[places[turning]])
        return q

    middle, draw = full(arm.middle()), _draws(arm)

    def solve(target: Any) -> Array | None:
        task.set_target(target)
        for attempt in range(RESTARTS + 1):
            configuration.update(middle if attempt == 0 else full(draw()))
            for _ in range(calls):
                if _small(task.compute_error(configuration), accuracy):
                    return plain(configuration.q)
                try:
                    velocity = library.solve_ik(
                        configuration, [task], 1.0, solver="daqp", limits=limits, safety_break=False
                    )
                except library.exceptions.NoSolutionFound:
                    break
                configuration.integrate_inplace(velocity, 1.0)
            if _small(task.compute_error(configuration), accuracy):
                return plain(configuration.q)
        return None

    return PreparedSolver(solve, convert=lambda target: pin.SE3(target))


def _draws(arm: Arm) -> Callable[[], Array]:
    generator = np.random.default_rng(0)
    return lambda: arm.draw(generator)


def _small(error: Array, accuracy: Accuracy) -> bool:
    x, y, z, a, b, c = error.tolist()
    return x * x + y * y + z * z <= accuracy.position**2 and a * a + b * b + c * c <= accuracy.orientation**2


PREBUILT = {"panda": "franka.panda_ik", "ur5": "universal_robots.ur5_ik", "xarm7": "ufactory.xarm7_ik"}
"""Arms for which ssik has a prebuilt solver."""


def ssik(arm: Arm, accuracy: Accuracy) -> PreparedSolver:
    """ssik's closed form of an arm with one solution; the transform of the target to its flange is not timed."""
    if arm.name not in PREBUILT:
        raise NotBuiltError("no prebuilt solver for this arm")
    module = importlib.import_module(f"ssik.prebuilt.{PREBUILT[arm.name]}")
    zero, q = np.zeros(module.DOF), arm.middle()
    offset = np.linalg.inv(module.fk(zero)) @ arm.pose(zero)
    if not np.allclose(module.fk(q) @ offset, arm.pose(q), rtol=0, atol=1e-9):
        raise NotBuiltError("its prebuilt solver is for another geometry")
    back = np.linalg.inv(offset)

    def solve(target: Array) -> Array | None:
        found = module.solve(target, max_solutions=1, respect_limits=True)
        return found[0].q if found else None

    return PreparedSolver(solve, convert=lambda target: target @ back)


class NotBuiltError(Exception):
    """A library has no solver for this arm."""


SOLVERS: dict[str, Builder] = {
    "jtik": jtik_damped,
    "jtik batch": jtik_batch,
    "jtik machine": jtik_machine,
    "jtik hybrid": jtik_hybrid,
    "rtb": toolbox,
    "optik": optik,
    "ssik": ssik,
    "mink": mink,
    "pink": pink,
}
OURS = tuple(name for name in SOLVERS if name.startswith("jtik"))
CLOSED_FORM = ("ssik",)
"""Solvers for one arm only; they are shown, but not used as the reference of ratios."""
SLOW = ("mink", "pink")
"""Loops in Python, which solve only some of the targets."""
