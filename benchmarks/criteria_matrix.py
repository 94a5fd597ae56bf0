"""Every registered criterion with every strategy on three robots: does a solve from a feasible start end as it should?

A cell is a criterion, a strategy and a robot: ten links with limits, a Panda, and a Panda on a vehicle. From a random
posture on its target, ``solve(until="stationary")`` should keep the task within its tolerance, not raise H, and end
stationary. No time is measured. Cells are kept in a file while they are computed, so that a run can be continued, and
several can run side by side; the page docs/guides/criteria_matrix.md is written from these files.

    python benchmarks/criteria_matrix.py [--robots panda] [--criteria look_at] [--strategies hybrid] [--starts 1]
    python benchmarks/criteria_matrix.py --page
"""

from __future__ import annotations

import argparse
import json
import warnings
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

import jtik
from jtik.robot import Mass
from jtik.testing import example_criterion

FILE = Path("criteria_matrix.json")
PAGE = Path(__file__).parents[1] / "docs" / "guides" / "criteria_matrix.md"

TOLERANCE = 1e-6
"""Default tolerance of the solver [m] and [rad]."""
RISE = 1e-6
"""Relative rise of H that the tolerance of the task permits."""
ITERATIONS = 2000
STARTS = 1
TRIES = 500
"""Random postures tried to find one at which H of self-collision is between 0 and 1, its value at contact."""

FIRST = ("hybrid", "hybrid+qp", "hybrid+second_order")
"""Strategies without an excuse: they are computed first, and lead the table."""

SIX_STARTS = (
    "From six starts each, `limit_norm` and `effective_mass` with the first three columns: 105 of 108 solves end as",
    "they should. On ten links `effective_mass` falls slowly along joint limits: `hybrid` needs 4,800 iterations from",
    "one start, `hybrid+qp` more than 2000 from two; `hybrid+second_order` needs at most 192 from all of them.",
)
"""What ``--starts 6`` gave for the two criteria whose curvature differs most from joint to joint."""

MARKS = {"as it should": "✓", "slow": "s", "saddle": "d", "off the task": "t", "H rises": "H", "refused": "–"}
"""The outcomes, best first, and their marks."""

REASONS = {
    "slow": f"on target, H has not risen, and is not stationary after {ITERATIONS} iterations or without progress",
    "saddle": "on target, at a saddle point or a maximum of H that the solver reports as such",
    "off the task": "the task is off by more than its tolerance: its step converges slowly, or is weighed against H",
    "H rises": "H is higher at the end than at the start",
    "refused": "the solver refuses the pair, or the robot",
}


def ten_links() -> jtik.Robot:
    """Ten unit links with limits, rods of 1 kg."""
    rod = Mass(1.0, [0.5, 0.0, 0.0], np.diag([0.0, 1 / 12, 1 / 12]))
    arm = jtik.Robot.planar(10, lower=-2.0, upper=1.5)
    return arm.with_masses({f"link{k}": rod for k in range(1, 11)})


ROBOTS = {
    "ten": ten_links,
    "panda": lambda: jtik.Robot.builtin("panda"),
    "vehicle": lambda: jtik.Robot.builtin("vehicle_panda"),
}
TITLES = {"ten": "Ten links", "panda": "Panda", "vehicle": "Panda on a vehicle"}


def strategies() -> tuple[str, ...]:
    """The names of the columns."""
    return (*FIRST, *(name for name in jtik.strategies if name not in FIRST))


def criteria() -> tuple[str, ...]:
    """The names of the rows: the criteria of jtik."""
    return tuple(n for n, plugin in jtik.criteria.loaded().items() if plugin.__module__.startswith("jtik_formulations"))


def outcome(robot: str, criterion: str, strategy: str, *, starts: int, iterations: int = ITERATIONS) -> dict[str, Any]:
    """The outcome of one cell, the worst over its starts, with the sentence of its solution."""
    body = ROBOTS[robot]()
    task = jtik.FrameTask(body.tip, "position" if body.dimension == 2 else "pose")
    made = example_criterion(jtik.criteria[criterion], body)
    try:
        ik = jtik.InverseKinematics(body, task, criteria=made, strategy=strategy)
    except jtik.JtikError as error:
        return {"outcome": "refused", "sentence": str(error)}
    found = [_one_start(ik, body, made, seed, iterations) for seed in range(starts)]
    return max(found, key=lambda each: list(MARKS).index(each["outcome"]))


def _one_start(
    ik: jtik.InverseKinematics, body: jtik.Robot, criterion: jtik.Criterion, seed: int, iterations: int
) -> dict[str, Any]:
    q0 = _start(body, criterion, seed)
    before = float(criterion(q0, body))
    solution = ik.solve(body.pose(q0), q0=q0, until="stationary", max_iterations=iterations)
    after = float(criterion(solution.q, body))
    error = max(solution.position_error, 0.0 if body.dimension == 2 else solution.orientation_error)
    if error > TOLERANCE:
        name = "off the task"
    elif after > before + RISE * max(1.0, abs(before)):
        name = "H rises"
    elif solution.status is jtik.Status.SADDLE:
        name = "saddle"
    else:
        name = "as it should" if solution.status is jtik.Status.CONVERGED else "slow"
    return {
        "outcome": name,
        "sentence": str(solution.status.value),
        "start": seed,
        "iterations": int(solution.iterations),
        "error": error,
        "H": [before, after],
        "residual": float(solution.null_space_residual),
    }


def _start(body: jtik.Robot, criterion: jtik.Criterion, seed: int) -> np.ndarray:
    """A random posture; for self-collision one at which bodies are near each other, and none touch."""
    rng = np.random.default_rng(seed)
    for _ in range(TRIES if criterion.name == "self_collision" else 0):
        q = body.random_configuration(rng)
        if 0 < float(criterion(q, body)) < 1:
            return q
    return body.random_configuration(seed)


def page(cells: dict[str, dict[str, Any]]) -> str:
    """The page of the documentation."""
    marks = "; ".join(f"`{mark}` {REASONS.get(name, name)}" for name, mark in MARKS.items())
    lines = [
        "# Every criterion with every strategy",
        "",
        "Written by [criteria_matrix.py](../../benchmarks/criteria_matrix.py). From a random posture on its target,",
        '`solve(until="stationary")` should keep the task within its tolerance, not raise H, and end stationary.',
        "For self-collision bodies are near each other at the start, and none touch: where a joint lies on the",
        "axis of another link H has a kink at its minimum, and first-order strategies end beside it.",
        "",
        f"{marks}; an empty cell has not been computed.",
        "",
        *SIX_STARTS,
        "",
    ]
    for robot, title in TITLES.items():
        lines += [f"## {title}", "", *_table(robot, cells), ""]
    return "\n".join([*lines, "## Cells that do not end so", "", *_failures(cells), ""])


def _table(robot: str, cells: dict[str, dict[str, Any]]) -> Iterator[str]:
    names = strategies()
    yield "| | " + " | ".join(f"`{name}`" for name in names) + " |"
    yield "| --- |" + " :-: |" * len(names)
    for criterion in criteria():
        found = [cells.get(f"{robot} {criterion} {name}", {}).get("outcome") for name in names]
        yield f"| `{criterion}` | " + " | ".join(MARKS.get(each, "") for each in found) + " |"


def _failures(cells: dict[str, dict[str, Any]]) -> Iterator[str]:
    for name, reason in REASONS.items():
        found = {key: cell for key, cell in cells.items() if cell["outcome"] == name}
        if not found:
            continue
        yield f"**{name[0].upper() + name[1:]}**: {reason}."
        yield ""
        for key, cell in sorted(found.items()):
            robot, criterion, strategy = key.split(" ")
            yield f"- {TITLES[robot]}, `{criterion}`, `{strategy}`: {_detail(cell)}"
        yield ""


def _detail(cell: dict[str, Any]) -> str:
    if "H" not in cell:
        return str(cell["sentence"])
    before, after = cell["H"]
    numbers = f"H {before:.4g} to {after:.4g}, null-space residual {cell['residual']:.1e}"
    text = f"{cell['sentence']}; {cell['iterations']} iterations, {numbers}"
    return f"{text}, error {cell['error']:.1e}" if cell["outcome"] == "off the task" else text


def main(arguments: Sequence[str] | None = None) -> None:
    """Compute the cells that are missing, and write the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robots", nargs="+", choices=ROBOTS, default=list(ROBOTS))
    parser.add_argument("--criteria", nargs="+", default=list(criteria()))
    parser.add_argument("--strategies", nargs="+", default=list(strategies()))
    parser.add_argument("--starts", type=int, default=STARTS, help="random postures in each cell")
    parser.add_argument("--again", action="store_true", help="compute cells again that the file has")
    parser.add_argument("--page", action="store_true", help="only write the page")
    parser.add_argument("--file", type=Path, default=FILE, help="the cells; created where there is none")
    parser.add_argument("--more", type=Path, nargs="*", default=[], help="files of other runs, for the page")
    given = parser.parse_args(arguments)
    cells = json.loads(given.file.read_text()) if given.file.is_file() else {}
    keys = [(r, c, s) for s in given.strategies for r in given.robots for c in given.criteria]
    for robot, criterion, strategy in [] if given.page else keys:
        key = f"{robot} {criterion} {strategy}"
        if key in cells and not given.again:
            continue
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            cells[key] = outcome(robot, criterion, strategy, starts=given.starts)
        print(f"{key}: {cells[key]['outcome']}; {_detail(cells[key])}", flush=True)
        given.file.write_text(json.dumps(cells, indent=0))
    for other in given.more:
        cells = json.loads(other.read_text()) | cells
    PAGE.write_text(page(cells), encoding="utf-8")


if __name__ == "__main__":
    main()
