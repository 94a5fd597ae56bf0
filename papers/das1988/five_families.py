# %% [markdown]
# # Das, Slotine and Sheridan 1988: five families of problems for one ten-link arm
#
# The paper makes claims about convergence without a table. This script computes such a table: transpose, Newton
# and hybrid updates for an arm of ten unit links in the plane, from generic, far and nearly straight starts, to
# targets inside, at the boundary of and beyond its workspace. There is no criterion, only the task.
#
# Run `python papers/das1988/five_families.py`, with `--quick` for a tenth of the problems. It writes
# `results/five_families.csv` and a figure, compares the numbers with `expected/five_families.csv`, and exits with
# status 1 if a number differs.

# %%
from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from claim import Row, Script, Within, median, percent

import jtik
from jtik_formulations import Hybrid, Newton, Transpose

LINKS = 10
TOLERANCE = 1e-6
"""Position error [m] at which a target counts as reached."""
MAX_ITERATIONS = 1000
PROBLEMS = 200
"""Problems of each family, for which the expected numbers hold."""
SEED = 1988
ROUNDING = 1e-12
"""Relative rise of V that is rounding of its evaluation."""

# Agreement with the expected numbers. The problems are bit-identical, so only rounding can differ: mathematical
# libraries disagree in the last digit, and long runs of the transpose method amplify this.
TOLERANCES = {
    "success": Within(absolute=1.0),
    "iterations": Within(relative=0.1),
    "rises": Within(absolute=2.0),
    "error": Within(absolute=math.inf),
}

ARM = jtik.Robot.planar(LINKS)

Array = np.ndarray
Problem = tuple[Array, Array]
"""Start (10,) [rad] and target (2,) [m]."""

# %% [markdown]
# ## The problems
#
# A target of the first two families is the tip position of another configuration drawn like the start, so that it
# is reachable by construction. For nearly straight starts the target lies on the arm's own line, where the gradient
# of a first-order method is almost zero.


# %%
def tip(q: Array) -> Array:
    """Tip position of the arm at q [m], in closed form."""
    angle = np.cumsum(q)
    return np.array([np.cos(angle).sum(), np.sin(angle).sum()])


def around(radius: float, rng: np.random.Generator) -> Array:
    """A point at distance ``radius`` from the base in a random direction [m]."""
    direction = rng.uniform(-np.pi, np.pi)
    return radius * np.array([np.cos(direction), np.sin(direction)])


def anywhere(spread: float) -> Callable[[np.random.Generator], Problem]:
    """Start and goal configuration uniform in (-spread, spread)."""
    return lambda rng: (rng.uniform(-spread, spread, LINKS), tip(rng.uniform(-spread, spread, LINKS)))


def straight(deviation: float) -> Callable[[np.random.Generator], Problem]:
    """Joint angles normal with standard deviation ``deviation`` [rad]; the target on the x axis between 3 and 9 m."""
    return lambda rng: (deviation * rng.standard_normal(LINKS), np.array([rng.uniform(3, 9), 0.0]))


def ring(radius: float) -> Callable[[np.random.Generator], Problem]:
    """A generic start; the target at distance ``radius`` from the base."""
    return lambda rng: (rng.uniform(-1, 1, LINKS), around(radius, rng))


REACHABLE: dict[str, Callable[[np.random.Generator], Problem]] = {
    "generic": anywhere(1.0),
    "far": anywhere(np.pi),
    "near-straight 1e-3": straight(1e-3),
    "near-straight 1e-6": straight(1e-6),
    "boundary 9.999": ring(9.999),
}
BEYOND = "unreachable 10.5"
FAMILIES = REACHABLE | {BEYOND: ring(10.5)}


def problems(family: str, count: int) -> Iterator[Problem]:
    """The first ``count`` problems of a family, the same for every method and count."""
    for index in range(count):
        yield FAMILIES[family](np.random.default_rng([SEED, list(FAMILIES).index(family), index]))


# %% [markdown]
# ## The methods
#
# The row "S as printed" takes (B.11) literally: 1/Q for revolute joints if Q exceeds its limit of 1 rad, and the
# same S inside N and D. On an arm of revolute joints alpha cancels S exactly, so this row agrees with "alpha only"
# up to rounding. The row "hybrid" is the dogleg alone, without the exploration that jtik adds to it.

# %%
METHODS: dict[str, jtik.Strategy] = {
    "transpose, alpha only": Transpose(q_limit=math.inf, backtracking=False),
    "transpose, S as printed": Transpose(rule="paper", q_limit=1.0, backtracking=False),
    "transpose, S after alpha": Transpose(backtracking=False),
    "transpose": Transpose(),
    "newton, undamped": Newton(q_limit=math.inf, backtracking=False),
    "newton, Q limit": Newton(backtracking=False),
    "newton": Newton(),
    "hybrid": Hybrid(explore=False),
}
METHODS_AS_PRINTED = ("transpose, alpha only", "transpose, S as printed")


def raised(trace: jtik.Trace) -> bool:
    """Whether V rose at an accepted step."""
    rose = (trace.accepted == 1) & (trace.actual_decrease < -ROUNDING * trace.V)
    return bool(rose.any())


def row(family: str, method: str, ik: jtik.InverseKinematics, count: int) -> Row:
    """One method on ``count`` problems of a family.

    Columns:
        success: share of targets reached [%].
        iterations: median over all problems, where a failure counts as infinite.
        rises: share of solves in which an accepted step raised V [%].
        error: median distance to the target at the end [m].
    """
    solutions = [
        ik.solve(target, q0=q0, max_iterations=MAX_ITERATIONS, position_tolerance=TOLERANCE, trace=True)
        for q0, target in problems(family, count)
    ]
    reached = [solution.position_error <= TOLERANCE for solution in solutions]
    return {
        "family": family,
        "method": method,
        "success": percent(reached),
        "iterations": median([s.iterations if ok else math.inf for s, ok in zip(solutions, reached, strict=True)]),
        "rises": percent(raised(solution.trace) for solution in solutions),
        "error": median([solution.position_error for solution in solutions]),
    }


def table(
    count: int = PROBLEMS,
    families: Iterable[str] = FAMILIES,
    methods: Iterable[str] = METHODS,
    tick: Callable[[str], None] = lambda label: None,
) -> list[Row]:
    """Every method on every family; ``tick`` is called with each completed row."""
    solvers = {name: jtik.InverseKinematics(ARM, jtik.FrameTask("tip"), strategy=METHODS[name]) for name in methods}
    rows = []
    for family in families:
        for name, ik in solvers.items():
            rows.append(row(family, name, ik, count))
            tick(f"{family}: {name}")
    return rows


# %% [markdown]
# ## Statements and expected numbers


# %%
def statements(rows: Iterable[Row]) -> dict[str, bool]:
    """The statements of the README about these rows, and whether they hold."""
    at: dict[tuple[str, str], Row] = {(str(row["family"]), str(row["method"])): row for row in rows}

    def every(column: str, holds: Callable[[float], bool], families: Iterable[str], methods: Iterable[str]) -> bool:
        return all(holds(float(at[f, m][column])) for f in families for m in list(methods))

    def steps(family: str, method: str) -> float:
        return float(at[family, method]["iterations"])

    own, straight, beyond = ("transpose", "newton", "hybrid"), ("near-straight 1e-3", "near-straight 1e-6"), [BEYOND]
    closest = float(at[BEYOND, "hybrid"]["error"])
    return {
        "with backtracking or dogleg V never rises": every("rises", lambda x: x == 0, FAMILIES, own),
        "alpha alone lets V rise in every family": every("rises", lambda x: x > 0, FAMILIES, METHODS_AS_PRINTED),
        "the hybrid reaches every target of the reachable families": every(
            "success", lambda x: x == 100, REACHABLE, ["hybrid"]
        ),
        "the hybrid needs no more iterations than the transpose in any family": all(
            steps(family, "hybrid") <= steps(family, "transpose") for family in REACHABLE
        ),
        "near the straight arm undamped Newton raises V": every(
            "rises", lambda x: x > 50, straight, ["newton, undamped"]
        ),
        "near the straight arm the Q limit alone prevents this": every(
            "rises", lambda x: x == 0, straight, ["newton, Q limit"]
        ),
        "S as printed changes nothing on a revolute arm": all(
            abs(steps(family, "transpose, S as printed") / steps(family, "transpose, alpha only") - 1) <= 0.05
            for family in REACHABLE
            if math.isfinite(steps(family, "transpose"))
        ),
        "the transpose reaches no target at the boundary": every(
            "success", lambda x: x == 0, ["boundary 9.999"], ["transpose", *METHODS_AS_PRINTED]
        ),
        "no method reaches the unreachable targets": every("success", lambda x: x == 0, beyond, METHODS),
        "for unreachable targets the hybrid ends at the smallest error, 0.5 m": math.isclose(
            closest, 0.5, abs_tol=1e-6
        ),
    }


def text(rows: Iterable[Row]) -> str:
    """Table with a row for each method and a column for each family: median iterations (success %) [rises %]."""
    at: dict[tuple[str, str], Row] = {(str(row["family"]), str(row["method"])): row for row in rows}
    families = list(dict.fromkeys(family for family, _ in at))
    lines = [["median iterations (success %) [V rose, %]", *families]]
    for method in dict.fromkeys(method for _, method in at):
        cells = []
        for family in families:
            each = at[family, method]
            count = f"{each['iterations']:g}" if math.isfinite(float(each["iterations"])) else "-"
            cells.append(f"{count} ({each['success']:g}) [{each['rises']:g}]")
        lines.append([method, *cells])
    widths = [max(len(line[column]) for line in lines) for column in range(len(families) + 1)]
    return "\n".join("  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)) for line in lines)


# %% [markdown]
# ## All methods from one nearly straight start


# %%
SHOWN = {
    "transpose, alpha only": ("#e3a48b", "-", 3.0),
    "transpose": ("#b0451c", "-", 1.4),
    "newton, undamped": ("#3b6ea5", "--", 1.4),
    "newton": ("#a9c6e3", "-", 5.0),
    "hybrid": ("#222222", "-", 1.4),
}
"""Colour, line style and width, so that coinciding lines are both visible."""
SHOWN_ITERATIONS = 100
"""Maximum number of iterations drawn."""
SMALLEST = 1e-16
"""Smallest V drawn [m^2]; the tolerance is at 5e-13."""


def draw(path: Path, family: str = "near-straight 1e-3") -> None:
    """Plot V by iteration, from the first start at which undamped methods raise V and all methods converge quickly."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    task = jtik.FrameTask("tip")
    solvers = {name: jtik.InverseKinematics(ARM, task, strategy=METHODS[name]) for name in SHOWN}

    def is_suitable(q0: Array, target: Array) -> bool:
        traces = {
            name: ik.solve(target, q0=q0, max_iterations=MAX_ITERATIONS, trace=True).trace
            for name, ik in solvers.items()
        }
        undamped = raised(traces["newton, undamped"]) and raised(traces["transpose, alpha only"])
        return undamped and max(map(len, traces.values())) <= SHOWN_ITERATIONS

    q0, target = next(problem for problem in problems(family, PROBLEMS) if is_suitable(*problem))
    figure, axes = pyplot.subplots(figsize=(7.5, 4.2), layout="constrained")
    for name, (color, dash, width) in SHOWN.items():
        trace = solvers[name].solve(target, q0=q0, trace=True).trace
        V = np.maximum(trace.error**2 / 2, SMALLEST)
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
    """A progress bar if rich is installed, otherwise one line for each completed row."""
    try:
        from rich.progress import Progress
    except ImportError:
        yield lambda label: print(label, file=sys.stderr, flush=True)
        return
    with Progress(transient=True) as bar:
        task = bar.add_task("solving", total=total)
        yield lambda label: bar.update(task, advance=1, description=label)


def compute(quick: bool) -> list[Row]:
    """The table, with a tenth of the problems if ``quick``."""
    with progress(len(FAMILIES) * len(METHODS)) as tick:
        return table(PROBLEMS // 10 if quick else PROBLEMS, tick=tick)


def figure(folder: Path, rows: Sequence[Row]) -> None:
    """The figure, which solves separate problems."""
    draw(folder / "near_straight.png")


SCRIPT = Script(
    name="five_families",
    keys=("family", "method"),
    tolerances=TOLERANCES,
    compute=compute,
    statements=statements,
    draw=figure,
    show=text,
)

if __name__ == "__main__":
    sys.exit(
        SCRIPT.main("Transpose, Newton and hybrid updates on five families of problems, and one unreachable family.")
    )
