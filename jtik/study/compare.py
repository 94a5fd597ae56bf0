"""compare: every strategy on the same problems, with the same starts, tolerances and judge."""

from __future__ import annotations

import platform
from collections.abc import Iterable, Mapping
from concurrent.futures import Executor
from dataclasses import replace
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jtik._loop.options import Until, read_request, read_settings
from jtik.constraints.clearance import Clearance, clearances_of
from jtik.criterion.base import Criterion, CriterionSum
from jtik.errors import ArgumentError
from jtik.problems import Case, ProblemSet
from jtik.progress import Progress, watched
from jtik.robot import Robot
from jtik.study.choose import problems_of
from jtik.study.comparison import Comparison
from jtik.study.contender import Setting
from jtik.study.fingerprint import fingerprint
from jtik.study.ruler import measures_of
from jtik.study.schedule import Schedule
from jtik.study.store import Notebook
from jtik.study.strategies import contenders_of
from jtik.study.units import Bench, Plan
from jtik.task import Task

Criteria = Criterion | CriterionSum | None


def compare(
    robot: Robot,
    task: Task | Iterable[Task],
    *,
    strategies: Any,
    criteria: Criteria | Mapping[str, Criteria] = None,
    problems: str | ProblemSet | Iterable[str | Case] | Mapping[str, int] = "reachable",
    count: int = 100,
    seed: int = 0,
    restarts: int = 0,
    position_tolerance: float = 1e-6,
    orientation_tolerance: float = 1e-6,
    optimality_tolerance: float = 1e-6,
    max_iterations: int = 1000,
    until: Until = "reached",
    limits: bool = True,
    clearances: Clearance | Iterable[Clearance] | None = None,
    joints: str | Iterable[str] | None = None,
    at: ArrayLike | None = None,
    compiled: bool = False,
    repeats: int = 3,
    traces: int = 5,
    executor: Executor | None = None,
    block: int = 20,
    save: str | Path | None = None,
    progress: Progress = False,
) -> Comparison:
    """Solve the same problems with every strategy; what each did is judged by kinematics of its own.

    A strategy that is unknown, cannot be built, is not installed or fails has rows that say so, and the study goes on.
    Ctrl-C ends it with what is done, ``complete=False``. Times are the medians of rounds in which the strategies take
    turns; the same study gives the same numbers but for its times, on however many processes.

    Args:
        robot: the robot.
        task: a Task, or several.
        strategies: names, Strategy objects, "peer:mink" or another of `jtik.study.peers.names`, contenders such as
            ``jtik.study.Law("damped", compiled=True)``; one, several, or a mapping from label to any of these.
        criteria: what to minimise with the freedom left; a mapping from label to criteria does the study with each.
        problems: a `jtik.problems.ProblemSet`, cases, or kinds of problems to draw: "reachable", "near_singular",
            "boundary", "unreachable", "near_limits", "circle", "line", "lissajous", "scene"; ``{kind: count}``.
        count: how many of each kind.
        seed: of the problems, the restarts and the order of turns.
        restarts, position_tolerance, orientation_tolerance, optimality_tolerance, max_iterations, until: of each
            solve, as in `InverseKinematics.solve`.
        limits: whether the robot's position limits hold.
        clearances, joints, at, compiled: as in `InverseKinematics`.
        repeats: how many rounds are timed; a case that takes more than 50 ms is timed once.
        traces: of how many cases of each kind, strategy and criteria the iterations are kept.
        executor: any `concurrent.futures.Executor` to spread the work: a process pool, Dask's
            ``client.get_executor()``, an MPI pool. This process alone when None.
        block: cases a unit of work.
        save: a ``.npz`` file that is written as the study goes, and gone on from where it is there.
        progress: True for a bar on the terminal, or a function called with (done, total) units.

    Raises:
        ArgumentError: for an argument that cannot be used, naming it: before anything is solved.
        UnknownNameError: for a kind of problems, a frame or a joint that does not exist.
        CriterionError: for a criterion that cannot be used.
        MissingExtraError: for a bar without rich.
    """
    read_request(restarts, seed, max_iterations)
    read_settings(position_tolerance, orientation_tolerance, optimality_tolerance, until)
    if not isinstance(limits, (bool, np.bool_)):
        raise ArgumentError("limits", limits, "True or False: whether position limits hold; a study has no others")
    setting = Setting(
        robot=robot,
        task=task if isinstance(task, Task) or not isinstance(task, Iterable) else tuple(task),
        position_tolerance=float(position_tolerance),
        orientation_tolerance=float(orientation_tolerance),
        optimality_tolerance=float(optimality_tolerance),
        max_iterations=int(max_iterations),
        until=until,
        restarts=int(restarts),
        seed=int(seed),
        limits=bool(limits),
        joints=joints if joints is None or isinstance(joints, str) else tuple(joints),
        at=None if at is None else np.array(_checked(robot).configuration(at, argument="at")),
        compiled=bool(compiled),
        clearances=clearances_of(clearances),
    )
    _checked(robot)
    setting.reduced()
    labelled = _labelled(criteria)
    measures = [each for own in labelled.values() for each in measures_of(own, ())]
    measures += measures_of(None, setting.clearances)
    plan = Plan(
        setting=setting,
        contenders=contenders_of(strategies),
        criteria=labelled,
        problems=problems_of(problems, setting, measures, count=count, seed=seed),
        repeats=_counted("repeats", repeats, 1),
        traces=_counted("traces", traces, 0),
        block=_counted("block", block, 1),
    )
    if executor is not None and not isinstance(executor, Executor):
        raise ArgumentError("executor", executor, "a concurrent.futures.Executor, or None")
    bench = _fitting(plan)
    machine = _machine()
    known = {"settings": _settings(plan), "machine": machine, "fingerprint": _fingerprint(plan, machine)}
    notebook = Notebook(save, plan, known)
    schedule = Schedule(plan, notebook.blocks, executor, bench)
    notebook.blocks = []
    try:
        for done in watched(schedule, progress, "units"):
            notebook.add(done)
    except KeyboardInterrupt:
        notebook.blocks += schedule.leftover()
    finally:
        schedule.cancel()
        notebook.write()
    return notebook.comparison()


def _checked(robot: Robot) -> Robot:
    if not isinstance(robot, Robot):
        raise ArgumentError("robot", robot, "a jtik.Robot")
    return robot


def _labelled(criteria: Any) -> dict[str, Criteria]:
    """The criteria by label: "" for those that are alone."""
    if not isinstance(criteria, Mapping):
        CriterionSum.of(criteria)
        return {"": criteria}
    if not criteria:
        raise ArgumentError("criteria", criteria, "at least one label, such as {'none': None}")
    for own in criteria.values():
        CriterionSum.of(own)
    return {str(label): own for label, own in criteria.items()}


def _counted(argument: str, value: Any, least: int) -> int:
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < least:
        raise ArgumentError(argument, value, f"an integer from {least}")
    return int(value)


def _fitting(plan: Plan) -> Bench:
    """What judges the study, once the problems fit the robot, its task and its criteria."""
    bench, setting = Bench(plan), plan.setting
    parameters = {name: value for label in plan.criteria for name, value in bench.ruler(label).parameters.items()}
    plan.problems.check(setting.robot, setting.task, joints=setting.joints, at=setting.at, parameters=parameters)
    return bench


def _settings(plan: Plan) -> dict[str, Any]:
    """The options as words and numbers."""
    setting, robot = plan.setting, plan.setting.robot
    return {
        "study": f"{len(plan.contenders)} strategies, {len(plan.problems)} problems on {robot.name!r}",
        "task": repr(setting.task),
        "strategies": {label: repr(contender) for label, contender in plan.contenders.items()},
        "criteria": {label: repr(own) for label, own in plan.criteria.items()},
        "clearances": [repr(clearance) for clearance in setting.clearances],
        "position_tolerance": setting.position_tolerance,
        "orientation_tolerance": setting.orientation_tolerance,
        "optimality_tolerance": setting.optimality_tolerance,
        "max_iterations": setting.max_iterations,
        "until": setting.until,
        "restarts": setting.restarts,
        "seed": setting.seed,
        "limits": setting.limits,
        "compiled": setting.compiled,
        "repeats": plan.repeats,
    }


def _fingerprint(plan: Plan, machine: Mapping[str, str]) -> str:
    """Of all that the numbers depend on: how they are divided into units is none of it."""
    return fingerprint(replace(plan, block=0), machine.get("jtik"))


def _machine() -> dict[str, str]:
    """Platform and versions."""
    versions = {}
    for package in ("jtik", "numpy", "casadi", "mujoco", "mink", "daqp"):
        try:
            versions[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            continue
    return {
        "platform": platform.platform(terse=True),
        "processor": platform.machine(),
        "python": platform.python_version(),
        **versions,
    }
