"""What a contender did on one case: times, answers, traces, or the reason why there are none."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from jtik.problems import Case
from jtik.result.solution import Trace
from jtik.study.contender import Answer

LONG = 0.05
"""Mean time for each target [s] above which a case is not timed again: repetition would change little."""


@dataclass(frozen=True)
class Failure:
    """Why a row has no figures.

    Attributes:
        status: status of the row.
        note: note of the row.
    """

    status: str
    note: str


@dataclass
class CaseRun:
    """One case solved by one contender.

    Attributes:
        case: the case.
        targets: its targets in the contender's form.
        seconds: mean time for each target, one value for each timed round [s].
        answers: answers of the first timed round, one for each target.
        traces: recorded iterations, one for each target.
        failure: the failure, if there was one.
    """

    case: Case
    targets: list[Any] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)
    answers: list[Answer] = field(default_factory=list)
    traces: list[Trace | None] = field(default_factory=list)
    failure: Failure | None = None


def checked(answer: Answer, nq: int) -> Answer:
    """The answer with q as an array of shape (nq,). Raises ValueError for another shape."""
    q = np.array(answer.q, dtype=np.float64)
    if q.shape != (nq,):
        raise ValueError(f"its answer has shape {q.shape}, not ({nq},)")
    return answer._replace(q=q)


def reason(error: BaseException) -> str:
    """The message of an error in one line."""
    text = " ".join(str(error).split()) or "no message"
    known = type(error).__module__.startswith("jtik.")
    return text if known or isinstance(error, ImportError) else f"{type(error).__name__}: {text}"
