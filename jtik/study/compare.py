"""`compare`: runs strategies and other libraries on the same problems with the same starts, tolerances and check."""

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

from jtik._loop.fingerprint import fingerprint
from jtik._loop.options import Until, read_executor, read_search_options, read_settings
from jtik.arguments import flag, instance, instances, integer, positive_integer
from jtik.constraints.clearance import Clearance, clearances_of
from jtik.constructors import lists_arguments
from jtik.criterion.base import Criterion, CriterionSum
from jtik.errors import ArgumentError, JtikError
from jtik.plotting.obstacles_in import obstacle_parameters
from jtik.problems import Case, ProblemSet
from jtik.progress import Progress, read_progress, watched
from jtik.registry import strategy_of
from jtik.registry.citation import entries_of
from jtik.robot import Robot
from jtik.study.comparison import Comparison
from jtik.study.contender import Setting
from jtik.study.metrics import measures_of
from jtik.study.result_file import ResultFile
from jtik.study.schedule import Schedule
from jtik.study.selection import select_problems
from jtik.study.strategies import contenders_of
from jtik.study.unit_runner import UnitRunner
from jtik.study.work_units import StudyPlan
from jtik.task import Task
from jtik.task.reduction import joints_of

Criteria = Criterion | CriterionSum | None

_TASK = "a jtik.Task such as jtik.FrameTask, or a list of them"


@lists_arguments
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
    """Compare strategies on the same problems, with the same starts and tolerances.

    Success and errors come from one independent check for all strategies. A strategy that is unknown, not installed,
    cannot be built or fails has rows that give the reason, and the study continues. After Ctrl-C the result has the
    completed rows and ``complete=False``. Times are medians over rounds in which the strategies take turns. The same
    study gives the same figures, except times, on any number of processes.

    Args:
        robot: the robot.
        task: a Task, or several.
        strategies: names, Strategy objects, "peer:mink" or another name of `jtik.study.peers.names`, or contenders
            such as ``jtik.study.StrategyContender("damped", compiled=True)``: one, several, or a mapping from label
            to any of these.
        criteria: criteria to minimise in the null space of the task. A mapping from label to criteria runs the study
            with each of them.
        problems: a `jtik.problems.ProblemSet`, cases, or kinds of problems to draw: "reachable", "near_singular",
            "boundary", "unreachable", "near_limits", "circle", "line", "lissajous", "scene". ``{kind: count}`` sets
            their numbers.
        count: number of cases of each kind.
        seed: seed of the problems, the restarts and the order within a timed round.
        restarts: maximum number of restarts of a solve, as in `InverseKinematics.solve`.
        position_tolerance: norm of the position error to reach [m].
        orientation_tolerance: norm of the orientation error to reach [rad].
        optimality_tolerance: norm of the projected gradient of H to reach, relative to max(1, |dH/dv|).
        max_iterations: maximum number of iterations of an attempt.
        until: "reached" stops on target; "stationary" continues until H is stationary.
        limits: whether the robot's position limits apply.
        clearances: distances to keep, as in `InverseKinematics`.
        joints: joints that move, as in `InverseKinematics`.
        at: configuration at which the other joints are locked, as in `InverseKinematics`.
        compiled: whether steps run as generated C, as in `InverseKinematics`.
        repeats: number of timed rounds; a case that takes more than 50 ms for each target is timed once.
        traces: number of cases of each kind, strategy and criteria whose iterations are kept.
        executor: a `concurrent.futures.Executor` for parallel work: a process pool, Dask's
            ``client.get_executor()``, an MPI pool. None runs the study in this process.
        block: number of cases of a work unit.
        save: a ``.npz`` file that is written while the study runs. If it exists, the study resumes from it.
        progress: True for a progress bar on the terminal, or a function called with (done, total) units.

    Returns:
        The comparison, with a row for each strategy, criteria and case.

    Raises:
        ArgumentError: naming an invalid argument, before anything is solved.
        UnknownNameError: for an unknown kind of problems, frame or joint.
        CriterionError: for an invalid criterion.
        MissingExtraError: for a progress bar without rich.

    Example:
        >>> study = jtik.compare(
        ...     jtik.Robot.planar(4), jtik.FrameTask("tip"), strategies=["hybrid", "newton"], problems={"reachable": 3}
        ... )
        >>> list(study.summary()["contender"])
        ['hybrid', 'newton']
    """
    read_search_options(restarts, seed, max_iterations)
    read_settings(position_tolerance, orientation_tolerance, optimality_tolerance, until)
    limits = flag("limits", limits, "whether position limits apply; a study has no other limits")
    progress, seed = read_progress(progress), integer("seed", seed)
    setting = Setting(
        robot=robot,
        task=instances("task", task, Task, _TASK),  # type: ignore[type-abstract]
        position_tolerance=float(position_tolerance),
        orientation_tolerance=float(orientation_tolerance),
        optimality_tolerance=float(optimality_tolerance),
        max_iterations=int(max_iterations),
        until=until,
        restarts=int(restarts),
        seed=int(seed),
        limits=limits,
        joints=joints_of(joints),
        at=None if at is None else np.array(_checked(robot).configuration(at, argument="at")),
        compiled=flag("compiled", compiled, "whether steps run as generated C"),
        clearances=clearances_of(clearances),
    )
    _checked(robot)
    setting.reduced()
    labelled = _labelled(criteria)
    measures = [each for own in labelled.values() for each in measures_of(own, ())]
    measures += measures_of(None, setting.clearances)
    plan = StudyPlan(
        setting=setting,
        contenders=contenders_of(strategies),
        criteria=labelled,
        problems=select_problems(problems, setting, measures, count=count, seed=seed),
        repeats=positive_integer("repeats", repeats),
        traces=integer("traces", traces),
        block=positive_integer("block", block),
    )
    read_executor(executor)
    runner = _checked_runner(plan)
    machine = _machine()
    known = {"settings": _settings(plan), "machine": machine, "fingerprint": _fingerprint(plan, machine)}
    known["obstacles"] = {label: obstacle_parameters(runner.metrics(label).parameters) for label in plan.criteria}
    result_file = ResultFile(save, plan, known)
    schedule = Schedule(plan, result_file.results, executor, runner)
    before = {result.unit for result in result_file.results}
    try:
        for result in watched(schedule, progress, "units"):
            if result.unit not in before:
                result_file.add(result)
    except KeyboardInterrupt:
        result_file.results += schedule.leftover()
    finally:
        schedule.cancel()
        result_file.write()
    return result_file.comparison()


def _checked(robot: Robot) -> Robot:
    return instance("robot", robot, Robot, "a jtik.Robot")


def _labelled(criteria: Any) -> dict[str, Criteria]:
    """The criteria by label; a single set of criteria has the label ""."""
    if not isinstance(criteria, Mapping):
        CriterionSum.of(criteria)
        return {"": criteria}
    if not criteria:
        raise ArgumentError("criteria", criteria, "at least one label, such as {'none': None}")
    for own in criteria.values():
        CriterionSum.of(own)
    return {str(label): own for label, own in criteria.items()}


def _checked_runner(plan: StudyPlan) -> UnitRunner:
    """The runner of the study, after a check that the problems fit the robot, the task and the criteria."""
    runner, setting = UnitRunner(plan), plan.setting
    parameters = {name: value for label in plan.criteria for name, value in runner.metrics(label).parameters.items()}
    plan.problems.check(setting.robot, setting.task, joints=setting.joints, at=setting.at, parameters=parameters)
    return runner


def _settings(plan: StudyPlan) -> dict[str, Any]:
    """The options as strings and numbers."""
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
        "citations": _citations(plan),
    }


def _citations(plan: StudyPlan) -> list[str]:
    """BibTeX entries of the sources of contenders and criteria; contenders whose strategy does not exist have none."""
    solvers: list[Any] = []
    for contender in plan.contenders.values():
        given = getattr(contender, "strategy", contender)
        try:
            solvers.append(strategy_of(given) if isinstance(given, str) else given)
        except JtikError:  # each of its rows has this error
            continue
    used = [CriterionSum.of(own) for own in plan.criteria.values()]
    return entries_of(solvers, used, clearances=bool(plan.setting.clearances))


def _fingerprint(plan: StudyPlan, machine: Mapping[str, str]) -> str:
    """Fingerprint of everything that the figures depend on, which excludes the size of the units."""
    return fingerprint(replace(plan, block=0), machine.get("jtik"))


def _machine() -> dict[str, str]:
    """Platform and package versions."""
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
