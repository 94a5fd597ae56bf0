"""Rows of a study: the results of one contender with one set of criteria on one case."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from jtik.result.solution import Status, Trace
from jtik.study import path_metrics
from jtik.study.independent_check import SLACK
from jtik.study.metrics import ConfigurationMetrics
from jtik.types import Array

if TYPE_CHECKING:
    from jtik.study.case_run import CaseRun
    from jtik.study.unit_runner import UnitRunner

NAN = math.nan
Flags = NDArray[np.bool_]

FALSE_SUCCESS = "reports success"
"""Beginning of the note if a contender reports success but the independent check finds the answer off target."""

OLD_FALSE_SUCCESS = "says it is on target"
"""The same beginning in files of earlier versions."""

FAILURES = ("not installed", "not built", "raised")
"""Status of rows without figures; the note gives the reason."""


@dataclass(frozen=True, kw_only=True)
class Row:
    """Results of one contender on one case. Figures that do not apply are NaN.

    Attributes:
        contender: label of the contender.
        criteria: label of the criteria.
        case: name of the case.
        kind: kind of the case.
        success: whether the answer is on target by the independent check, within the limits if they apply, and
            reported as stationary if ``until="stationary"``. For a path, all answers must be.
        status: the contender's status. For a path, that of the first failure, or of the last target.
        note: what else went wrong.
        iterations: number of iterations. For a path, the mean over its targets.
        seconds: median time of a solve [s]. For a path, the mean over its targets.
        seconds_low: smallest time of the rounds [s].
        seconds_high: largest time of the rounds [s].
        seconds_per_iteration: time of an iteration [s].
        position_error: norm of the position error by the independent check [m]. For a path, the largest.
        orientation_error: norm of the orientation error by the independent check [rad]. For a path, the largest.
        H: value of the criteria at the answer. For a path, the mean.
        regret: H minus the smallest H of the contenders that solved this case with these criteria.
        monotone: 1 if V never rose at an accepted step, 0 if it did.
        clearance: smallest distance to an obstacle over the iterates of the last attempt, or along the path [m].
        limit_margin: smallest distance of a joint to a limit relative to its range, negative outside the limits.
        leakage: largest ``|J nu| / |nu|`` of a null-space step.
        path_length: length in joint space of the accepted iterates, or of the path [rad] and [m].
        smoothness: root mean square of the joint acceleration along a path [rad/s^2].
        drift: joint-space distance between first and last configuration of a closed path [rad] and [m].
        condition: condition number of the task Jacobian at the answer. For a path, the largest.
    """

    contender: str
    criteria: str
    case: str
    kind: str
    success: bool = False
    status: str = ""
    note: str = ""
    iterations: float = NAN
    seconds: float = NAN
    seconds_low: float = NAN
    seconds_high: float = NAN
    seconds_per_iteration: float = NAN
    position_error: float = NAN
    orientation_error: float = NAN
    H: float = NAN
    regret: float = NAN
    monotone: float = NAN
    clearance: float = NAN
    limit_margin: float = NAN
    leakage: float = NAN
    path_length: float = NAN
    smoothness: float = NAN
    drift: float = NAN
    condition: float = NAN

    @classmethod
    def failed(cls, key: tuple[str, str, str], kind: str, status: str, note: str) -> Row:
        """A row without figures.

        Args:
            key: names of contender, criteria and case.
            kind: kind of the case.
            status: why there are no figures.
            note: text of the error.
        """
        contender, criteria, case = key
        return cls(contender=contender, criteria=criteria, case=case, kind=kind, status=status, note=note)


COLUMNS = tuple(each.name for each in fields(Row))
"""Names of the columns in order."""

TEXTS = ("contender", "criteria", "case", "kind", "status", "note")
"""Names of the text columns."""


def measured(key: tuple[str, str, str], runner: UnitRunner, run: CaseRun, postures: Array) -> Row:
    """The row of a case for which the contender gave answers.

    Args:
        key: names of contender, criteria and case.
        runner: the runner, with the independent check and the metrics.
        run: what the contender did.
        postures: the answers, one for each target, (k, nq).
    """
    contender, criteria, name = key
    case, setting, check, metrics = run.case, runner.plan.setting, runner.check, runner.metrics(criteria)
    metrics.set(case.parameters)
    numbers = [runner.tasks.read_target(target) for target in case.targets]
    pairs = list(zip(postures, numbers, strict=True))
    errors = np.array([check.errors(q, target) for q, target in pairs])
    H, condition = np.array([metrics.at(q, target)[::2] for q, target in pairs]).T
    allowed = np.array([setting.position_tolerance, setting.orientation_tolerance]) + SLACK
    on_target = np.array([(each <= allowed).all() for each in errors])
    within = np.array([check.within(q) or not setting.limits for q in postures])
    claimed = np.array([answer.claimed for answer in run.answers])
    solved = on_target & within & (claimed | (setting.until == "reached"))
    iteration_counts = [NAN if answer.iterations is None else float(answer.iterations) for answer in run.answers]
    iterations = float(np.mean(iteration_counts))
    seconds = float(np.median(run.seconds))
    # with restarts, an answer off target may come from an earlier attempt than the last
    known = [trace if on or not setting.restarts else None for trace, on in zip(run.traces, on_target, strict=True)]
    ends = [metrics.at(trace.q[-1], target)[1] if trace else NAN for trace, target in zip(known, numbers, strict=True)]
    figures = _path_figures(runner, metrics, run, postures, known, ends)
    return Row(
        contender=contender,
        criteria=criteria,
        case=name,
        kind=case.kind,
        success=bool(solved.all()),
        status=run.answers[int(np.argmin(solved)) if not solved.all() else -1].status,
        note=_note(errors, on_target, within, claimed) or _compromise(run, solved),
        iterations=iterations,
        seconds=seconds,
        seconds_low=min(run.seconds),
        seconds_high=max(run.seconds),
        seconds_per_iteration=seconds / iterations if iterations > 0 else NAN,
        position_error=float(errors[:, 0].max()) if check.has_position else NAN,
        orientation_error=float(errors[:, 1].max()) if check.has_orientation else NAN,
        H=float(H.mean()),
        limit_margin=min(check.margin(q) for q in postures),
        condition=float(condition.max()),
        **figures,
    )


def _path_figures(
    runner: UnitRunner,
    metrics: ConfigurationMetrics,
    run: CaseRun,
    postures: Array,
    traces: list[Trace | None],
    ends: list[float],
) -> dict[str, float]:
    """Figures of the iterations of a solve, whose final V is in ``ends``, or of the configurations along a path."""
    setting, case, robot = runner.plan.setting, run.case, runner.robot
    tolerance = min(setting.position_tolerance, setting.orientation_tolerance)
    followed = [(trace, end) for trace, end in zip(traces, ends, strict=True) if trace is not None]
    falls = [path_metrics.monotone(trace, end, tolerance) for trace, end in followed]
    leaks = [path_metrics.leakage(trace) for trace, _ in followed]
    figures = {"monotone": _smallest(falls), "leakage": -_smallest([-leak for leak in leaks])}
    if case.is_path:
        own = postures
        figures["path_length"] = path_metrics.path_length(robot, own)
        figures["smoothness"] = path_metrics.smoothness(robot, own, case.dt)
        figures["drift"] = path_metrics.drift(robot, own) if case.closed else NAN
    elif followed:
        own = path_metrics.iterates(followed[0][0])
        figures["path_length"] = path_metrics.path_length(robot, own)
    else:
        own = postures
    figures["clearance"] = metrics.clearance(own)
    return figures


def _smallest(figures: list[float]) -> float:
    """The smallest figure, ignoring NaN; NaN if there is no other."""
    return min((figure for figure in figures if not math.isnan(figure)), default=NAN)


def _note(errors: Array, on_target: Flags, within: Flags, claimed: Flags) -> str:
    """Differences between what the contender reports and what the independent check finds."""
    if (claimed & ~on_target).any():
        position, orientation = errors[claimed & ~on_target].max(axis=0)
        return f"{FALSE_SUCCESS}, but the error is {position:.3g} m and {orientation:.3g} rad"
    return "" if within.all() else "outside the joint limits"


def _compromise(run: CaseRun, solved: Flags) -> str:
    """The sentence of the status COMPROMISE where an answer that is no success has it; else nothing."""
    pairs = zip(run.answers, solved, strict=True)
    ended = any(answer.status == Status.COMPROMISE.name and not good for answer, good in pairs)
    return Status.COMPROMISE.value if ended else ""
