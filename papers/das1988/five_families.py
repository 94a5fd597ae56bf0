# %% [markdown]
# # Das, Slotine and Sheridan 1988: five families of problems for one ten-link arm
#
# The paper makes claims about convergence without a table. This script makes the table: transpose, Newton
# and hybrid updates on an arm of ten unit links in the plane, from ordinary, far and nearly straight
# starts, to targets inside, on the edge of and beyond its reach. No criterion takes part: this is about the
# task alone.
#
# Run `python papers/das1988/five_families.py`. It writes `results/five_families.csv` and a figure beside
# it, compares the numbers with `expected/five_families.csv` and exits with status 1 if one of them differs.

# %%
from __future__ import annotations

import argparse
import csv
import math
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, fields
from pathlib import Path

import numpy as np

import jtik
from jtik_formulations import Hybrid, Newton, Transpose

HERE = Path(__file__).parent
LINKS = 10
TOLERANCE = 1e-6
"""Position error [m] at which a target counts as reached."""
MAX_ITERATIONS = 1000
PROBLEMS = 200
"""Problems a family; the expected numbers hold for this many."""
SEED = 1988
ROUNDING = 1e-12
"""Relative rise of V below which it is the rounding of two evaluations and not a rise."""

# Agreement with the expected numbers. The problems are the same to the bit, so what can differ is rounding:
# mathematical libraries disagree in the last place, and a long run of the transpose method amplifies that.
SUCCESS_POINTS = 1.0
MEDIAN_SHARE = 0.10
RISES_POINTS = 2.0

ARM = jtik.Robot.planar(LINKS)

Array = np.ndarray
Problem = tuple[Array, Array]
"""Start (10,) [rad] and target (2,) [m]."""

# %% [markdown]
# ## The problems
#
# A target of the first two families is the tip of another configuration drawn like the start, so that it is
# reachable by construction. Near the straight arm the target lies on the arm's own line, which is where a
# first-order method feels almost no torque.


# %%
def tip(q: Array) -> Array:
    """The tip of the arm at q [m], in closed form."""
    angle = np.cumsum(q)
    return np.array([np.cos(angle).sum(), np.sin(angle).sum()])


def around(radius: float, rng: np.random.Generator) -> Array:
    """A point at that distance from the base, in a random direction [m]."""
    direction = rng.uniform(-np.pi, np.pi)
    return radius * np.array([np.cos(direction), np.sin(direction)])


def anywhere(spread: float) -> Callable[[np.random.Generator], Problem]:
    """Start and goal configuration uniform in (-spread, spread)."""
    return lambda rng: (rng.uniform(-spread, spread, LINKS), tip(rng.uniform(-spread, spread, LINKS)))


def straight(bend: float) -> Callable[[np.random.Generator], Problem]:
    """Joint angles normal with deviation ``bend``, the target on the x axis between 3 and 9 m."""
    return lambda rng: (bend * rng.standard_normal(LINKS), np.array([rng.uniform(3, 9), 0.0]))


def ring(radius: float) -> Callable[[np.random.Generator], Problem]:
    """An ordinary start, the target at that distance from the base."""
    return lambda rng: (rng.uniform(-1, 1, LINKS), around(radius, rng))


REACHABLE: dict[str, Callable[[np.random.Generator], Problem]] = {
    "generic": anywhere(1.0),
    "far": anywhere(np.pi),
    "near-straight 1e-3": straight(1e-3),
    "near-straight 1e-6": straight(1e-6),
    "boundary 9.999": ring(9.999),
}
FAMILIES = REACHABLE | {"unreachable 10.5": ring(10.5)}


def problems(family: str, count: int) -> Iterator[Problem]:
    """The first ``count`` problems of a family: the same ones for every method and every count."""
    for index in range(count):
        yield FAMILIES[family](np.random.default_rng([SEED, list(FAMILIES).index(family), index]))


# %% [markdown]
# ## The methods
#
# The row "S as printed" takes (B.11) literally: 1/Q for revolute joints where Q exceeds its limit of 1 rad,
# and the same S inside N and D. On an arm of revolute joints alpha then undoes S exactly, so this row
# repeats "alpha only" up to rounding.

# %%
METHODS: dict[str, jtik.Strategy] = {
    "transpose, alpha only": Transpose(q_limit=math.inf, backtracking=False),
    "transpose, S as printed": Transpose(rule="paper", q_limit=1.0, backtracking=False),
    "transpose, S after alpha": Transpose(backtracking=False),
    "transpose": Transpose(),
    "newton, undamped": Newton(q_limit=math.inf, backtracking=False),
    "newton, Q limit": Newton(backtracking=False),
    "newton": Newton(),
    "hybrid": Hybrid(),
}


@dataclass(frozen=True)
class Row:
    """One method on one family.

    success: share of targets reached [%]. iterations: median over all problems, a failure counting as infinite.
    rises: share of solves in which an accepted step raised V [%]. error: median distance to the target at the end [m].
    """

    family: str
    method: str
    success: float
    iterations: float
    rises: float
    error: float


def raised(trace: jtik.Trace) -> bool:
    """Whether V rose at an accepted step."""
    rose = (trace.accepted == 1) & (trace.actual_decrease < -ROUNDING * trace.V)
    return bool(rose.any())


def row(family: str, method: str, ik: jtik.InverseKinematics, count: int) -> Row:
    """Solve ``count`` problems of the family."""
    solutions = [
        ik.solve(target, q0=q0, max_iterations=MAX_ITERATIONS, position_tolerance=TOLERANCE, trace=True)
        for q0, target in problems(family, count)
    ]
    reached = [solution.position_error <= TOLERANCE for solution in solutions]
    spent = [s.iterations if ok else math.inf for s, ok in zip(solutions, reached, strict=True)]
    return Row(
        family=family,
        method=method,
        success=100 * float(np.mean(reached)),
        iterations=_median(spent),
        rises=100 * float(np.mean([raised(solution.trace) for solution in solutions])),
        error=_median([solution.position_error for solution in solutions]),
    )


def _median(values: list[float]) -> float:
    """The median, where infinite values may stand in the middle."""
    ordered, half = sorted(values), len(values) // 2
    return ordered[half] if len(values) % 2 or math.isinf(ordered[half]) else (ordered[half - 1] + ordered[half]) / 2


def table(
    count: int = PROBLEMS,
    families: Iterable[str] = FAMILIES,
    methods: Iterable[str] = METHODS,
    tick: Callable[[str], None] = lambda label: None,
) -> list[Row]:
    """Every method on every family; ``tick`` is told what was done."""
    solvers = {name: jtik.InverseKinematics(ARM, jtik.FrameTask("tip"), strategy=METHODS[name]) for name in methods}
    rows = []
    for family in families:
        for name, ik in solvers.items():
            rows.append(row(family, name, ik, count))
            tick(f"{family}: {name}")
    return rows


# %% [markdown]
# ## What must hold, and what is expected


# %%
def broken(rows: Iterable[Row]) -> list[str]:
    """The statements of the README that these rows contradict, in words; empty if all hold."""
    at = {(row.family, row.method): row for row in rows}
    found = []

    def hold(statement: str, holds: bool) -> None:
        if not holds:
            found.append(statement)

    for family in FAMILIES:
        for method in ("transpose", "newton", "hybrid"):
            hold(f"{family}: {method} never raises V", at[family, method].rises == 0)
    for family in REACHABLE:
        hold(f"{family}: hybrid reaches every target", at[family, "hybrid"].success == 100)
        quicker = at[family, "hybrid"].iterations <= at[family, "transpose"].iterations
        hold(f"{family}: hybrid needs no more iterations than transpose", quicker)
    for family in ("near-straight 1e-3", "near-straight 1e-6"):
        hold(f"{family}: undamped Newton raises V", at[family, "newton, undamped"].rises > 0)
        hold(f"{family}: the Q limit cures that", at[family, "newton, Q limit"].rises == 0)
    for method in METHODS:
        hold(f"unreachable 10.5: {method} reaches nothing", at["unreachable 10.5", method].success == 0)
    closest = at["unreachable 10.5", "hybrid"].error
    hold("unreachable 10.5: hybrid ends 0.5 m away, the least possible", abs(closest - 0.5) < 1e-6)
    edge = at["boundary 9.999", "transpose"]
    hold("boundary 9.999: transpose reaches less than half of the targets", edge.success < 50)
    return found


def differing(rows: Iterable[Row], expected: Iterable[Row]) -> list[str]:
    """Which figures differ from the expected ones by more than the tolerances above, in words."""
    known = {(row.family, row.method): row for row in expected}
    found = []
    for row in rows:
        if (row.family, row.method) not in known:
            found.append(f"{row.family}, {row.method}: not among the expected rows")
            continue
        other = known[row.family, row.method]
        for name, allowed in (
            ("success", SUCCESS_POINTS),
            ("rises", RISES_POINTS),
            ("iterations", MEDIAN_SHARE * other.iterations),
        ):
            now, then = getattr(row, name), getattr(other, name)
            if now != then and not abs(now - then) <= allowed:
                found.append(f"{row.family}, {row.method}: {name} {now:g}, expected {then:g} +- {allowed:.3g}")
    return found


def write(path: Path, rows: Iterable[Row]) -> None:
    """Rows as csv."""
    path.parent.mkdir(exist_ok=True)
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, [field.name for field in fields(Row)], lineterminator="\n")
        writer.writeheader()
        for each in rows:
            numbers = {key: f"{value:.6g}" for key, value in asdict(each).items() if isinstance(value, float)}
            writer.writerow(asdict(each) | numbers)


def read(path: Path) -> list[Row]:
    """Rows from csv."""
    with path.open(newline="", encoding="utf-8") as file:
        return [
            Row(**{name: value if name in ("family", "method") else float(value) for name, value in line.items()})
            for line in csv.DictReader(file)
        ]


def text(rows: Iterable[Row]) -> str:
    """The table, one method a line and one family a column: median iterations (success %) [rises %]."""
    at = {(row.family, row.method): row for row in rows}
    families = list(dict.fromkeys(family for family, _ in at))
    lines = [["median iterations (success %) [V rose, %]", *families]]
    for method in dict.fromkeys(method for _, method in at):
        cells = []
        for family in families:
            each = at[family, method]
            count = f"{each.iterations:g}" if math.isfinite(each.iterations) else "-"
            cells.append(f"{count} ({each.success:g}) [{each.rises:g}]")
        lines.append([method, *cells])
    widths = [max(len(line[column]) for line in lines) for column in range(len(families) + 1)]
    return "\n".join("  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)) for line in lines)


# %% [markdown]
# ## One nearly straight start, every method


# %%
SHOWN = {
    "transpose, alpha only": ("#e3a48b", "-", 3.0),
    "transpose": ("#b0451c", "-", 1.4),
    "newton, undamped": ("#3b6ea5", "--", 1.4),
    "newton": ("#a9c6e3", "-", 5.0),
    "hybrid": ("#222222", "-", 1.4),
}
"""Colour, dash and width: where two lines coincide, both can be seen."""
SHOWN_ITERATIONS = 100
"""Most iterations to draw."""
LEAST = 1e-16
"""Smallest V drawn [m^2]; the tolerance is at 5e-13."""


def draw(path: Path, family: str = "near-straight 1e-3") -> None:
    """V after every iteration, from the family's first start where undamped methods raise V and all arrive soon."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    task = jtik.FrameTask("tip")
    solvers = {name: jtik.InverseKinematics(ARM, task, strategy=METHODS[name]) for name in SHOWN}

    def telling(q0: Array, target: Array) -> bool:
        traces = {
            name: ik.solve(target, q0=q0, max_iterations=MAX_ITERATIONS, trace=True).trace
            for name, ik in solvers.items()
        }
        undamped = raised(traces["newton, undamped"]) and raised(traces["transpose, alpha only"])
        return undamped and max(map(len, traces.values())) <= SHOWN_ITERATIONS

    q0, target = next(problem for problem in problems(family, PROBLEMS) if telling(*problem))
    figure, axes = pyplot.subplots(figsize=(7.5, 4.2), layout="constrained")
    for name, (color, dash, width) in SHOWN.items():
        trace = solvers[name].solve(target, q0=q0, trace=True).trace
        V = np.maximum(trace.error**2 / 2, LEAST)
        marker = "o" if len(trace) < 15 else None
        axes.semilogy(range(len(V)), V, dash, color=color, linewidth=width, marker=marker, label=name, ms=3.5)
    axes.axhline(TOLERANCE**2 / 2, color="#999999", linewidth=0.8)
    right = axes.get_yaxis_transform()
    axes.text(0.42, TOLERANCE**2, "tolerance", transform=right, ha="center", fontsize=8, color="#666666")
    axes.set(xlabel="iteration", ylabel="$V = |e|^2/2$  [m$^2$]", xlim=(0, None))
    axes.set_title(f"Ten links bent by about 1e-3 rad; target on their line at {target[0]:.2f} m", fontsize=10)
    axes.legend(frameon=False, fontsize=9)
    axes.spines[["top", "right"]].set_visible(False)
    path.parent.mkdir(exist_ok=True)
    figure.savefig(path, dpi=150)
    pyplot.close(figure)


# %% [markdown]
# ## Run it


# %%
@contextmanager
def progress(total: int) -> Iterator[Callable[[str], None]]:
    """A progress bar where rich is installed, otherwise one line for each row done."""
    try:
        from rich.progress import Progress
    except ImportError:
        yield lambda label: print(label, file=sys.stderr, flush=True)
        return
    with Progress(transient=True) as bar:
        task = bar.add_task("solving", total=total)
        yield lambda label: bar.update(task, advance=1, description=label)


def main(arguments: list[str] | None = None) -> int:
    """Compute, write, draw, compare. The exit status."""
    parser = argparse.ArgumentParser(description="Transpose, Newton and hybrid updates on five families, and one.")
    parser.add_argument("--problems", type=int, default=PROBLEMS, help="problems a family (default %(default)s)")
    parser.add_argument("--no-figure", action="store_true", help="do not draw")
    parser.add_argument("--accept", action="store_true", help="make these numbers the expected ones")
    options = parser.parse_args(arguments)
    if options.problems < 1:
        parser.error("--problems must be at least 1")
    with progress(len(FAMILIES) * len(METHODS)) as tick:
        rows = table(options.problems, tick=tick)
    print(text(rows))
    write(HERE / "results" / "five_families.csv", rows)
    if not options.no_figure:
        draw(HERE / "results" / "near_straight.png")
    trouble = broken(rows)
    expected = HERE / "expected" / "five_families.csv"
    if options.problems != PROBLEMS:
        print(f"not compared: the expected numbers are for {PROBLEMS} problems a family")
    elif options.accept:
        write(expected, rows)
    else:
        trouble += differing(rows, read(expected))
    for line in trouble:
        print(f"DIFFERS  {line}", file=sys.stderr)
    if not trouble:
        print("as expected")
    return 1 if trouble else 0


if __name__ == "__main__":
    sys.exit(main())
