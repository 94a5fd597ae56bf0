"""Figure 2.2: a ten-link arm moves through a field of obstacles.

The available copies lack the drawings. The figure here follows the text: ten links in the plane, a path of the tip as
an operator might enter it, obstacle avoidance and zero joint angles as criteria. The field is that of jtik's demo. The
script draws six configurations and computes the clearances of the joints, which the paper's potential repels, and of
the links. It compares zero angles alone, the method as printed, and a potential that includes the links.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from functools import cache
from pathlib import Path

import numpy as np
from claim import AS_IT_TURNS, MEDIAN, Row, Script, Within, by_key, median, percent

import jtik
from jtik import plotting
from jtik.demo.measure import clearances
from jtik.demo.scene import Scene
from jtik_formulations import Hybrid, JointCentering, ObstacleAvoidance, ProjectedGradient, Transpose

SCENE = Scene()
TARGETS, FEW = 61, 16
PANELS = 6
WINDOW: plotting.Window = (-2.9, 9.5, -2.6, 3.6)
CASES = {
    "zero angles alone": (JointCentering(), Hybrid()),
    "joints, as printed": (
        JointCentering() + ObstacleAvoidance(SCENE.obstacles),
        Transpose(rule="paper", q_limit=1.0, backtracking=False, secondary=ProjectedGradient(rule="paper")),
    ),
    "joints, transpose": (JointCentering() + ObstacleAvoidance(SCENE.obstacles), Transpose()),
    "joints, hybrid": (JointCentering() + ObstacleAvoidance(SCENE.obstacles), Hybrid()),
    "joints and links, hybrid": (JointCentering() + ObstacleAvoidance(SCENE.obstacles, bodies="both"), Hybrid()),
}
SHOWN = "joints and links, hybrid"


@cache
def follow(case: str, targets: int) -> tuple[np.ndarray, tuple[int, ...], tuple[bool, ...]]:
    """Configurations (targets, 10), iterations, and whether each target was reached."""
    criteria, strategy = CASES[case]
    ik = jtik.InverseKinematics(SCENE.robot, jtik.FrameTask("tip"), criteria=criteria, strategy=strategy)
    q, path, iterations, reached = np.array(SCENE.start), [], [], []
    for target in SCENE.path(targets):
        solution = ik.solve(target, q0=q, max_iterations=1000, jump_limit=AS_IT_TURNS)
        q = solution.q
        path.append(q)
        iterations.append(solution.iterations)
        reached.append(solution.position_error <= 1e-6)
    return np.array(path), tuple(iterations), tuple(reached)


def row(case: str, targets: int) -> Row:
    """The path with one criterion and strategy.

    Columns:
        joints: smallest clearance of a joint from a disc [m], negative inside.
        links: smallest clearance of a link from a disc [m], negative inside.
        norm: median of |q| [rad].
        reached: targets reached [%].
        iterations: median iterations for a target.
    """
    q, iterations, reached = follow(case, targets)
    joints, links = clearances(plotting.Skeleton(SCENE.robot).links(q), SCENE.obstacles)
    return {
        "case": case,
        "joints": float(joints.min()),
        "links": float(links.min()),
        "norm": float(np.median(np.linalg.norm(q, axis=1))),
        "reached": percent(reached),
        "iterations": median(iterations),
    }


def compute(quick: bool) -> list[Row]:
    """The path with every criterion and strategy."""
    return [row(case, FEW if quick else TARGETS) for case in CASES]


def statements(rows: Sequence[Row]) -> dict[str, bool]:
    """Statements about these rows, and whether they hold."""
    at = by_key(rows, ["case"])
    none, joints, links = at["zero angles alone"], at["joints, hybrid"], at[SHOWN]
    printed, transpose = at["joints, as printed"], at["joints, transpose"]
    return {
        "the hybrid reaches every target": all(row["reached"] == 100 for row in (none, joints, links)),
        "the transpose with jtik's rules reaches more targets than as printed": float(transpose["reached"])
        > float(printed["reached"]),
        "the method as printed misses targets, winds the arm up and moves joints into discs": float(printed["reached"])
        < 100
        and float(printed["norm"]) > 10
        and float(printed["joints"]) < 0,
        "zero angles alone move joints and links through the discs": float(none["joints"]) < 0
        and float(none["links"]) < 0,
        "with the potential on the joints no joint touches a disc": float(joints["joints"]) > 0
        and float(transpose["joints"]) > 0,
        "but a link does": float(joints["links"]) < 0,
        "with links in the potential no link does": float(links["links"]) > 0,
    }


def draw(folder: Path, rows: Sequence[Row]) -> None:
    """Six panels: the arm, its configuration of the previous panel in a light colour, and the path of the tip."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    q = follow(SHOWN, TARGETS)[0]
    path = SCENE.path(TARGETS)
    chosen = np.linspace(0, TARGETS - 1, PANELS).round().astype(int)
    left, right, bottom, top = WINDOW
    width = 14.0
    figure = Figure(figsize=(width, width / 3 * 2 * (top - bottom) / (right - left) + 0.3), layout="constrained")
    FigureCanvasAgg(figure)
    figure.set_facecolor(plotting.BACKGROUND)
    grid = figure.subplots(2, 3, sharex=True, sharey=True)
    skeleton = plotting.Skeleton(SCENE.robot)
    for panel, (axes, k) in enumerate(zip(grid.flat, chosen, strict=True)):
        axes.set(xlim=(left, right), ylim=(bottom, top), aspect="equal", facecolor=plotting.BACKGROUND)
        plotting.frame_axes(axes)
        axes.tick_params(color=plotting.THIN, labelcolor=plotting.MUTED, labelsize=10)
        if panel >= 3:
            axes.set_xlabel("x [m]", color=plotting.MUTED, fontsize=11)
        if panel % 3 == 0:
            axes.set_ylabel("y [m]", color=plotting.MUTED, fontsize=11)
        label = f"{panel + 1}   target {k + 1} of {TARGETS}"
        axes.text(0.02, 0.96, label, transform=axes.transAxes, va="top", fontsize=12, color=plotting.INK)
    figure.draw_without_rendering()  # link widths are in metres, so the layout must be computed first
    for panel, (axes, k) in enumerate(zip(grid.flat, chosen, strict=True)):
        plotting.draw_obstacles(axes, SCENE.obstacles)
        plotting.draw_path(axes, path, color=plotting.THIN)
        if panel:
            plotting.draw_path(axes, path[: k + 1])
            before = plotting.DrawnArm(
                axes, skeleton, color=plotting.shades(PANELS)[1], joints=False, halo=False, zorder=2.5
            )
            before.move(q[chosen[panel - 1]])
        plotting.DrawnArm(axes, skeleton, color=plotting.shades(PANELS)[-1]).move(q[k])
        plotting.draw_base(axes)
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / "figure_2_2.png", dpi=110)


SCRIPT = Script(
    name="figure_2_2",
    keys=("case",),
    tolerances={
        "joints": Within(absolute=5e-3),
        "links": Within(absolute=5e-3),
        "norm": Within(absolute=0.02),
        "reached": Within(absolute=2.0),
        "iterations": MEDIAN,
    },
    compute=compute,
    statements=statements,
    draw=draw,
)

if __name__ == "__main__":
    sys.exit(SCRIPT.main(__doc__))
