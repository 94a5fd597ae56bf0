"""Steps of a controller in generated C, beside placo, mink and pink: the rows of native.py for steps.

Three problems: a Panda whose velocity limits are active, a Panda that tracks a path, and ten links among four circles
with a row for each of the 40 pairs. Each is measured hot, where one step follows the other, and cold, where other code
runs between two steps and touches 8 MB, as in a controller. The problems and the peers are those of qp_step.py and
clearances.py, which also check the answers.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import clearances
import numpy as np
import qp_step
from qp_step import Clock

import jtik

STRATEGIES = ("weighted_qp", "hybrid+qp")
"""Rows of jtik; ratios are those to the first."""

COLD = {"hot": False, "cold": True}

Timer = Callable[[], float]
"""() -> mean time of a step [s]."""

PANDA = {"at limits": "saturated", "tracking": "tracked"}
"""Problems of a Panda, and the path of each in qp_step.py."""
OBSTACLES = "ten links, four circles"


@dataclass(frozen=True)
class Figures:
    """Figures of one row.

    Attributes:
        problem: what is solved.
        name: strategy of jtik, or library.
        caches: "hot" or "cold".
        times: time of a step in each round [us].
        ratios: the same over that of the first row of jtik in the same round.
        checked: what the check of the answers found.
    """

    problem: str
    name: str
    caches: str
    times: np.ndarray
    ratios: np.ndarray
    checked: str

    def record(self) -> dict[str, Any]:
        """Median, tenth and ninetieth percentile, as plain data."""
        times, ratios = (np.percentile(each, [50, 10, 90]).round(3).tolist() for each in (self.times, self.ratios))
        return {**{key: getattr(self, key) for key in ("problem", "name", "caches", "checked")}} | {
            "microseconds": times,
            "ratio": ratios,
        }


def measured(rounds: int, clock: Clock) -> list[Figures | str]:
    """All rows; a text where a library is not installed."""
    timers: dict[tuple[str, str, str], Timer] = {}
    checks: dict[tuple[str, str], str] = {}
    missing: list[Figures | str] = []
    for add in (_panda, _obstacles):
        missing += add(timers, checks, clock)
    times = qp_step.interleaved(timers, rounds)  # type: ignore[arg-type]
    found: list[Figures | str] = []
    for (problem, name, caches), each in times.items():  # type: ignore[misc]
        ours = times[problem, STRATEGIES[0], caches]  # type: ignore[index]
        found.append(Figures(problem, name, caches, each, each / ours, checks[problem, name]))
    return found + missing


def _panda(timers: dict[tuple[str, str, str], Timer], checks: dict[tuple[str, str], str], clock: Clock) -> list[str]:
    panda, missing = jtik.Robot.builtin("panda"), []
    robot = jtik.Robot.from_urdf(qp_step.urdf(panda), tip=panda.tip)
    pose = qp_step.independent_pose(robot)
    for problem, of in PANDA.items():
        path = qp_step.PATHS[of](robot, panda.keyframes["home"])
        builds: dict[str, Callable[[], qp_step.Step]] = {
            name: lambda name=name, path=path: qp_step.stepping(qp_step.solver(robot, path, name, compiled=True))
            for name in STRATEGIES
        }
        builds |= {name: lambda build=build, path=path: build(robot, path) for name, build in qp_step.PEERS.items()}
        for name, build in builds.items():
            try:
                step = build()
            except ImportError as error:
                missing.append(f"{problem}, {name}: not installed: {error}")
                continue
            left, beyond, active = qp_step.checked(step, robot, path, pose)
            over = f", {beyond:.1e} rad beyond limits" if beyond > qp_step.ACCURACY else ""
            checks[problem, name] = f"error left {left:.1e}, {active:.0%} at limits{over}"
            for caches, cold in COLD.items():
                timers[problem, name, caches] = qp_step.path_time(step, path, clock, cold=cold)
    return missing


def _obstacles(
    timers: dict[tuple[str, str, str], Timer], checks: dict[tuple[str, str], str], clock: Clock
) -> list[str]:
    robot, missing = clearances.arm(), []
    builds: dict[str, Callable[[], clearances.Step]] = {
        name: lambda name=name: clearances.stepping(clearances.solver(robot, name, code="C")) for name in STRATEGIES
    }
    builds |= {name: lambda name=name: clearances.PEERS[name](robot) for name in ("mink (DAQP)", "placo (C++)")}
    for name, build in builds.items():
        try:
            checked = clearances.checked(name, build())
        except ImportError as error:
            missing.append(f"{OBSTACLES}, {name}: not installed: {error}")
            continue
        checks[OBSTACLES, name] = f"clearance {checked.clearance:.1f} mm, tip error {checked.missed:.2f} mm"
        for caches, cold in COLD.items():
            lap = clearances.lap_time(build(), clearances.HOME, clearances.targets(), clock, cold=cold)
            timers[OBSTACLES, name, caches] = lap
    return missing


def show(rows: list[Figures | str]) -> None:
    """Print the rows: microseconds, and how many times those of jtik's first row."""
    print(f"{'':24} {'':12} {'':5} {'µs a step (10 to 90 %)':>26} {'x ' + STRATEGIES[0]:>22}")
    for row in rows:
        if isinstance(row, str):
            print(row)
            continue
        (median, low, high), (ratio, least, most) = (row.record()[key] for key in ("microseconds", "ratio"))
        times, ratios = f"{median:.2f} ({low:.2f} to {high:.2f})", f"{ratio:.2f} ({least:.2f} to {most:.2f})"
        print(f"{row.problem:24} {row.name:12} {row.caches:5} {times:>26} {ratios:>22}  {row.checked}")
