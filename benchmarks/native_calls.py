"""Solves for one target a call: what the calls take, on average and at the ninety-fifth percentile."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

Array = np.ndarray

Call = Callable[[Any], Array | None]
"""A target in the form of a library -> a configuration, or None for no answer."""


@dataclass(frozen=True)
class CallTimes:
    """Times of the calls of a library; that of a target is the median of the rounds.

    Attributes:
        name: name of the row.
        mean: mean over the targets [µs].
        median: median over the targets [µs].
        p95: their ninety-fifth percentile [µs].
        p99: their ninety-ninth percentile [µs].
        right: share of right answers.
    """

    name: str
    mean: float
    median: float
    p95: float
    p99: float
    right: float

    def record(self) -> dict[str, Any]:
        """As it is written to a file."""
        return asdict(self)


def measured(
    rows: dict[str, tuple[Call, list[Any]]],
    rounds: int,
    clock: Callable[[], int],
    right: Callable[[list[Array | None]], int],
) -> list[CallTimes]:
    """The times of all rows.

    Args:
        rows: by name the call, and the targets in its form.
        rounds: number of rounds; the rows of one follow one another, and each begins with another row.
        clock: the time [ns].
        right: of the answers of a row, how many are right.
    """
    answers = {name: [call(target) for target in targets] for name, (call, targets) in rows.items()}
    times: dict[str, list[list[float]]] = {name: [] for name in rows}
    names = list(rows)
    for k in range(rounds):
        for name in names[k % len(names) :] + names[: k % len(names)]:
            call, targets = rows[name]
            own = []
            for target in targets:
                begin = clock()
                call(target)
                own.append((clock() - begin) / 1e3)
            times[name].append(own)
    found = []
    for name in names:
        of_targets = np.median(times[name], axis=0)
        median, p95, p99 = np.percentile(of_targets, [50, 95, 99]).tolist()
        share = right(answers[name]) / len(answers[name])
        found.append(CallTimes(name, float(of_targets.mean()), median, p95, p99, share))
    return found


def show(rows: list[CallTimes]) -> None:
    """Print the times."""
    print(f"{'':34} {'mean [µs]':>10} {'median':>8} {'p95':>8} {'p99':>8} {'right':>9}")
    for row in rows:
        figures = f"{row.mean:>10.2f} {row.median:>8.2f} {row.p95:>8.2f} {row.p99:>8.2f}"
        print(f"{row.name:34} {figures} {100 * row.right:>7.2f} %")
