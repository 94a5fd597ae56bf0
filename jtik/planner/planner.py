"""The interactive planner: an operator guides the end effector through an obstacle field."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable, Iterable
from concurrent.futures import Executor, ThreadPoolExecutor
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import ArrayLike

from jtik.arguments import array_of, flag, instance, non_negative_number, positive_number, several
from jtik.arguments import path as read_path
from jtik.constraints import Limits
from jtik.constraints.limits import limits_of
from jtik.constructors import Constructed
from jtik.criterion import Criteria, Criterion, CriterionSum
from jtik.demo.scene import Scene as Demo
from jtik.errors import ArgumentError
from jtik.geometry import Scene, Slots, Solid
from jtik.geometry.slots import read_obstacles
from jtik.planner.files import sessions
from jtik.planner.files.journal import Journal
from jtik.planner.files.plan_file import Plan
from jtik.planner.session import catalogue
from jtik.planner.session.loop import DT, Loop
from jtik.planner.session.settings import Problem, Structure, Values, joint_weights
from jtik.planner.session.solving import GIVEN, Solver
from jtik.planner.session.state import Messages, State
from jtik.registry import strategy_of
from jtik.robot import JointType, Robot
from jtik.robot.joint_weights import Weights
from jtik.strategy import Strategy
from jtik.task import FrameTask
from jtik.task.reduction import reduced

if TYPE_CHECKING:
    from jtik.planner.web.server import Server

CRITERIA = ("joint_centering", "obstacle_avoidance")
"""The criteria of the paper's Figure 2.2."""

SPEED = {JointType.PRISMATIC: 0.5}
"""Largest speed of a joint whose robot has none [m/s]; of others `TURN`."""

TURN = 2.0
"""Largest speed of a joint whose robot has none [rad/s]."""

HEIGHT = 760
"""Height of the page in a notebook [pixel]."""

SAFE = 0.02
"""Smallest distance that the clearance allows, unless another one is set [m]."""


class Planner(metaclass=Constructed):
    """A session of an operator who guides the end effector of a robot, changes obstacles and settings, and records.

    The target moves at a limited speed, and one step of the solver follows it 60 times a second, in a thread that
    `start` begins and `close` ends. `submit` takes edits (`jtik.planner.edits.messages`) from any thread; `frame`,
    `status`, `settings` and `history` are the latest values, which any thread may read. What compiled functions read
    changes at once; another strategy, criterion or capacity is built in a worker while the present solver goes on::

        with jtik.planner.Planner() as planner:
            planner.loop.submit(MoveTarget((6.0, 1.0)))

    Without a robot it is the ten-link arm in an obstacle field of the paper's Figure 2.2.

    Args:
        robot: the robot; a planar arm of ten links by default.
        task: what its end effector does; a position in the plane, a pose in space by default. Of several tasks the
            operator guides one at a time, the first one at first; the others are held where their targets are.
        scene: the obstacles: a `jtik.Scene`, or obstacles; none by default, with the default robot a field of discs.
        strategy: name of a registered strategy, perhaps with a secondary term, or a Strategy object.
        criteria: names of criteria, criteria, or a weighted sum; "joint_centering" and "obstacle_avoidance" by default.
            Those given by name keep away from the obstacles of the scene, however many there are; a criterion that was
            built with obstacles keeps its places for them.
        q0: where the arm begins, (nq,); `Robot.home` by default.
        limits: True for the robot's own limits, with 2 rad/s and 0.5 m/s for joints that have no limit of speed; False
            without limits of position; or a `jtik.Limits`.
        weights: weights of the joints, as in `jtik.InverseKinematics`: heavy joints move less for the task.
        safe: smallest distance to obstacles that the clearance allows, once it is switched on [m].
        target_speed: largest speed [m/s] and angular speed [rad/s] of the target; by default a sixth of the robot's
            reach, and 1 rad/s.
        dt: period [s].
        compiled: whether solvers run as generated C, as in `jtik.InverseKinematics`.
        folder: where what is recorded is kept against the end of the process: a folder of the user's by default, False
            for nowhere.
        clock: the time [s].
        executor: where solvers are built; threads of its own by default.

    Attributes:
        loop: the loop.

    Raises:
        ArgumentError: for an argument that cannot be used, naming it.
        UnknownNameError: for a frame, strategy or criterion that does not exist.

    Source: Das, Slotine and Sheridan (1988), sections 2.4 and 3.
    """

    def __init__(
        self,
        robot: Robot | None = None,
        task: FrameTask | Iterable[FrameTask] | None = None,
        *,
        scene: Scene | Iterable[Solid] | Solid | None = None,
        strategy: str | Strategy = "hybrid",
        criteria: Criteria = CRITERIA,
        q0: ArrayLike | None = None,
        limits: bool | Limits = True,
        weights: Weights = None,
        safe: float = SAFE,
        target_speed: tuple[float, float] | None = None,
        dt: float = DT,
        compiled: bool = False,
        folder: str | os.PathLike[str] | bool | None = None,
        clock: Callable[[], float] = time.monotonic,
        executor: Executor | None = None,
    ) -> None:
        demo = Demo() if robot is None else None
        full = demo.robot if demo else instance("robot", robot, Robot, "a jtik.Robot, or None for a ten-link arm")
        wanted = _tasks(task, full)
        moving, _ = reduced(full, wanted, None, full.neutral)
        field = {f"disc {i}": each for i, each in enumerate(demo.obstacles, 1)} if demo and scene is None else scene
        obstacles = _scene(field, full.dimension)
        dt, compiled = positive_number("dt", dt), flag("compiled", compiled)
        safe, speeds = non_negative_number("safe", safe), _speeds(target_speed)
        start = moving.home if q0 is None else moving.configuration(q0, argument="q0")
        if not callable(clock):
            raise ArgumentError("clock", clock, "a function that returns the time [s]")
        if executor is not None:
            instance("executor", executor, Executor, "a concurrent.futures.Executor, or None")
        messages = Messages(clock)
        journal, former = _journal(folder, moving, messages)
        names, terms, given = _criteria(criteria)
        problem = Problem(
            robot=moving,
            tasks=wanted,
            criteria=catalogue.Criteria(given),
            weights=terms,
            bodies="shapes" if any(_moves(moving, frame) for frame in moving.shapes) else "both",
            limits=_limits(limits, moving),
            strategy=None if isinstance(strategy, str) else strategy_of(strategy),
            compiled=compiled,
        )
        structure = Structure(
            strategy=strategy if isinstance(strategy, str) else GIVEN,
            options={},
            criteria=names,
            limits=problem.limits.position,
            clearance=False,
            slots=Slots.of(obstacles, None, moving.dimension),
            joint_weights=joint_weights(moving, weights),
        )
        solver = Solver(problem, structure)
        preferred = np.clip(moving.neutral, moving.lower, moving.upper)
        values = Values(obstacles, preferred, {}, safe)
        solver.fill(values)
        if demo and q0 is None:
            start = solver.ik.solve(demo.path(2)[0], q0=demo.start).q
        state = State(problem, solver, values, start, messages=messages)
        state.set_target_speed(*(speeds or (state.arm.reach / 6, 1.0)))
        self._executor = ThreadPoolExecutor(2, "jtik planner") if executor is None else executor
        self._own_executor = executor is None
        self._server: Server | None = None
        self.loop = Loop(state, self._executor, clock=clock, dt=dt, journal=journal, sessions=former)

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def start(self) -> None:
        """Begin to move the arm, in a thread of its own."""
        self.loop.start()

    def serve(self, port: int = 0) -> Server:
        """Start, and serve the page of the planner on this machine, in a thread of its own.

        Args:
            port: the port; 0 for any free one.

        Returns:
            The server, whose ``url`` is the address of the page. `close` closes it.

        Raises:
            ArgumentError: for a number that is no port.
            MissingExtraError: when websockets is not installed.
            PortInUseError: when another program uses the port.
        """
        from jtik.planner.web.desk import Desk
        from jtik.planner.web.server import Server

        if self._server is None:
            server = Server(Desk(self.loop), port=port)
            self.start()
            self._server = server.start()
        return self._server

    def _repr_html_(self) -> str:
        """The page in a notebook, whose kernel is on this machine."""
        url = self.serve().url
        return f'<iframe src="{url}" width="100%" height="{HEIGHT}" style="border: 0" allow="gamepad"></iframe>'

    def close(self) -> None:
        """End the page, the thread and the session; what was recorded is kept."""
        if self._server is not None:
            self._server.close()
            self._server = None
        self.loop.close()
        if self._own_executor:
            self._executor.shutdown(wait=False, cancel_futures=True)


def _tasks(given: Any, robot: Robot) -> tuple[FrameTask, ...]:
    """The tasks. Raises ArgumentError for anything else."""
    if given is None:
        return (FrameTask(robot.tip, kind="position" if robot.dimension == 2 else "pose"),)
    accepted = "a jtik.FrameTask, several of them, or None"
    tasks = several("task", given if isinstance(given, Iterable) else [given], accepted)
    for task in tasks:
        instance("task", task, FrameTask, accepted)
    if not tasks:
        raise ArgumentError("task", given, accepted)
    return tuple(tasks)


def _scene(given: Any, dimension: int) -> Scene:
    """The obstacles. Raises ArgumentError for anything else, naming the argument."""
    try:
        scene = Scene(() if given is None else given)
        read_obstacles(scene, dimension)
    except ArgumentError as error:
        raise ArgumentError("scene", error.given, f"a jtik.Scene, or obstacles: {error.accepted}") from None
    return scene


def _moves(robot: Robot, frame: str) -> bool:
    return any(joint.is_moving for joint in robot.path(frame))


def _criteria(given: Any) -> tuple[tuple[str, ...], dict[str, float], dict[str, Criterion]]:
    """Names of the criteria, their weights, and those that were given as objects, by name."""
    names, weights, objects = list[str](), dict[str, float](), dict[str, Criterion]()
    for each in given if isinstance(given, (list, tuple)) else [given]:
        if isinstance(each, str):
            names.append(each)
            continue
        for name, weight, criterion in CriterionSum.of(each).named():
            names.append(name)
            weights[name], objects[name] = weight, criterion
    repeated = [name for name in names if names.count(name) > 1]
    if repeated:
        raise ArgumentError("criteria", f"{repeated[0]!r} more than once", "criteria with a name each")
    return tuple(names), weights, objects


def _limits(given: bool | Limits, robot: Robot) -> Limits:
    """The limits; without limits of speed, those of careful steering."""
    limits = limits_of(given)
    if isinstance(given, Limits):
        return limits
    speeds = robot.velocity_limit.copy()
    for joint in robot.independent_joints:
        own = speeds[robot.v_slice(joint.name)]
        own[~np.isfinite(own)] = SPEED.get(joint.type, TURN)
    return Limits(position=limits.position, velocity=tuple(speeds.tolist()))


def _speeds(given: object) -> tuple[float, float] | None:
    """Largest speed [m/s] and angular speed [rad/s] of the target; None where none are given."""
    if given is None:
        return None
    accepted = "two positive numbers: a speed [m/s] and an angular speed [rad/s]"
    speed, turn = array_of("target_speed", given, [(2,)], accepted, lambda x: (x > 0) & (x < math.inf)).tolist()
    return speed, turn


def _journal(
    folder: str | os.PathLike[str] | bool | None, robot: Robot, messages: Messages
) -> tuple[Journal | None, tuple[sessions.Session, ...]]:
    """The journal of the session, and the sessions before it that can be recovered."""
    if folder is False:
        return None, ()
    if folder is True:
        raise ArgumentError("folder", folder, "the path of a folder, None for one of the user's, or False")
    where = None if folder is None else read_path("folder", folder)
    former = tuple(each for each in sessions.recoverable(where) if not each.closed)

    def tell(level: str, text: str) -> None:
        messages.tell("error" if level == "error" else "info", text)

    return Journal(sessions.new_folder(where, tell=tell), robot=Plan.robot_of(robot), tell=tell), former
