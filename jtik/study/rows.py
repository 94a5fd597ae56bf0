"""A row of a study: one contender, one set of criteria, one case, and every figure of it."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from jtik.result.solution import Trace
from jtik.study import measures
from jtik.study.judge import SLACK
from jtik.study.ruler import Ruler
from jtik.types import Array

if TYPE_CHECKING:
    from jtik.study.units import Attempt, Bench

NAN = math.nan
Flags = NDArray[np.bool_]

CLAIMS = "says it is on target"
"""How the note begins of an answer that its contender takes for one and the judge does not."""

FAILURES = ("not installed", "not built", "raised")
"""The status of rows without figures; the note says more."""


@dataclass(frozen=True, kw_only=True)
class Row:
    """What is known of one case; NaN where there is nothing to measure.

    Attributes:
        contender, criteria, case, kind: which it is.
        success: on target by the judge's measure, within the limits where they hold, and stationary if asked.
        status: why the solve stopped, in the contender's words; of a path the first that failed, or the last.
        note: what went wrong besides.
        iterations: steps tried; of a path the mean of a target.
        seconds: median time of a solve [s]; of a path of its mean over the targets.
        seconds_low, seconds_high: the least and the largest of the rounds [s].
        seconds_per_iteration: [s].
        position_error, orientation_error: judged [m], [rad], where the task has such rows; of a path the worst.
        H: the criteria's value at the answer; of a path the mean.
        regret: H less the least that a contender reached which solved this case with these criteria.
        monotone: 1 where V never rose at an accepted step, 0 where it did.
        clearance: least distance to an obstacle at the iterates of the answer's attempt, or along the path [m].
        limit_margin: least distance of a joint to a limit as a share of its range, negative outside.
        leakage: largest ``|J nu| / |nu|`` of a null-space step.
        path_length: length of the way in joint space [rad] and [m]: over accepted iterates, or along the path.
        smoothness: root mean square of the acceleration along a path [rad/s^2].
        drift: distance between first and last posture of a closed path [rad] and [m].
        condition: condition number of the task's Jacobian at the answer; of a path the worst.
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
        """The row of something that has no figures."""
        contender, criteria, case = key
        return cls(contender=contender, criteria=criteria, case=case, kind=kind, status=status, note=note)


COLUMNS = tuple(each.name for each in fields(Row))
"""The columns of a study, in their order."""

TEXTS = ("contender", "criteria", "case", "kind", "status", "note")
"""Those that are words."""


def measured(key: tuple[str, str, str], bench: Bench, attempt: Attempt, postures: Array) -> Row:
    """The row of a case that was solved, well or badly.

    Args:
        key: contender, criteria and case.
        bench: with the judge and the ruler.
        attempt: what the contender did.
        postures: its answers, one a target, (k, nq).
    """
    contender, criteria, name = key
    case, setting, judge, ruler = attempt.case, bench.plan.setting, bench.judge, bench.ruler(criteria)
    ruler.set(case.parameters)
    numbers = [bench.tasks.read_target(target) for target in case.targets]
    pairs = list(zip(postures, numbers, strict=True))
    errors = np.array([judge.errors(q, target) for q, target in pairs])
    H, condition = np.array([ruler.at(q, target)[::2] for q, target in pairs]).T
    allowed = np.array([setting.position_tolerance, setting.orientation_tolerance]) + SLACK
    on_target = np.array([(each <= allowed).all() for each in errors])
    within = np.array([judge.within(q) or not setting.limits for q in postures])
    claimed = np.array([answer.claimed for answer in attempt.answers])
    good = on_target & within & (claimed | (setting.until == "reached"))
    told = [NAN if answer.iterations is None else float(answer.iterations) for answer in attempt.answers]
    iterations = float(np.mean(told))
    seconds = float(np.median(attempt.seconds))
    # with restarts an answer off target need not be where the last attempt ended
    known = [trace if on or not setting.restarts else None for trace, on in zip(attempt.traces, on_target, strict=True)]
    ends = [ruler.at(trace.q[-1], target)[1] if trace else NAN for trace, target in zip(known, numbers, strict=True)]
    way = _way(bench, ruler, attempt, postures, known, ends)
    return Row(
        contender=contender,
        criteria=criteria,
        case=name,
        kind=case.kind,
        success=bool(good.all()),
        status=attempt.answers[int(np.argmin(good)) if not good.all() else -1].status,
        note=_note(errors, on_target, within, claimed),
        iterations=iterations,
        seconds=seconds,
        seconds_low=min(attempt.seconds),
        seconds_high=max(attempt.seconds),
        seconds_per_iteration=seconds / iterations if iterations > 0 else NAN,
        position_error=float(errors[:, 0].max()) if judge.lengths else NAN,
        orientation_error=float(errors[:, 1].max()) if judge.angles else NAN,
        H=float(H.mean()),
        limit_margin=min(judge.margin(q) for q in postures),
        condition=float(condition.max()),
        **way,
    )


def _way(
    bench: Bench,
    ruler: Ruler,
    attempt: Attempt,
    postures: Array,
    traces: list[Trace | None],
    ends: list[float],
) -> dict[str, float]:
    """The figures of the way: of the iterations of a solve, whose V ends at ``ends``, or of the postures of a path."""
    setting, case, robot = bench.plan.setting, attempt.case, bench.robot
    tolerance = min(setting.position_tolerance, setting.orientation_tolerance)
    followed = [(trace, end) for trace, end in zip(traces, ends, strict=True) if trace is not None]
    falls = [measures.monotone(trace, end, tolerance) for trace, end in followed]
    leaks = [measures.leakage(trace) for trace, _ in followed]
    figures = {"monotone": _least(falls), "leakage": -_least([-leak for leak in leaks])}
    if case.is_path:
        own = postures
        figures["path_length"] = measures.path_length(robot, own)
        figures["smoothness"] = measures.smoothness(robot, own, case.dt)
        figures["drift"] = measures.drift(robot, own) if case.closed else NAN
    elif followed:
        own = measures.iterates(followed[0][0])
        figures["path_length"] = measures.path_length(robot, own)
    else:
        own = postures
    figures["clearance"] = ruler.clearance(own)
    return figures


def _least(figures: list[float]) -> float:
    """The least of those that are numbers; NaN where none is."""
    return min((figure for figure in figures if not math.isnan(figure)), default=NAN)


def _note(errors: Array, on_target: Flags, within: Flags, claimed: Flags) -> str:
    """What the contender says and the judge does not find."""
    if (claimed & ~on_target).any():
        position, orientation = errors[claimed & ~on_target].max(axis=0)
        return f"{CLAIMS}, but is {position:.3g} m and {orientation:.3g} rad off"
    return "" if within.all() else "outside the joint limits"
