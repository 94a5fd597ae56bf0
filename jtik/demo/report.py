"""The results of the demo: tables for the terminal, and a JSON file."""

from __future__ import annotations

import json
import platform
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from jtik.demo.measure import PathResult, StrategyResult
from jtik.demo.scene import Scene
from jtik.result.status import Status

if TYPE_CHECKING:
    from rich.table import Table


_STYLE: dict[str, Any] = {"title_justify": "left", "title_style": "bold", "caption_justify": "left", "pad_edge": False}


def path_table(result: PathResult) -> Table:
    """The figures of the path through the field, one a row."""
    from rich import box
    from rich.table import Table

    table = Table(title="The path through the field", show_header=False, box=box.SIMPLE, **_STYLE)
    table.add_column(style="bold")
    table.add_column(justify="right")
    for name, text in (
        ("targets reached", f"{result.reached} of {len(result.q)}"),
        ("largest residual", f"{result.residuals.max():.1e} m"),
        ("smallest joint clearance", f"{result.joint_clearance.min():.3f} m"),
        ("smallest link clearance", f"{result.link_clearance.min():.3f} m"),
        ("mean iterations a target", f"{result.iterations.mean():.0f}"),
        ("time a step", f"{1e6 * result.step_seconds:.1f} µs"),
    ):
        table.add_row(name, text)
    return table


def strategy_table(results: Sequence[StrategyResult]) -> Table:
    """The solves of the strategies, one a row."""
    from rich import box
    from rich.markup import escape
    from rich.table import Table

    table = Table(
        title="The last target from the same start, by strategy",
        box=box.HORIZONTALS,
        show_edge=False,
        padding=0,
        **_STYLE,
    )
    table.add_column("strategy", style="bold", no_wrap=True)
    table.add_column("status", overflow="fold", min_width=len("compromise"))
    headings = (
        "steps",
        "residual\n[m]",
        "V rises\nby [m²]",
        "H",
        "joint\ngap\n[m]",
        "link\ngap\n[m]",
        "a step\n[µs]",
    )
    for heading in headings:
        width = max(map(len, heading.splitlines()))
        table.add_column(escape(heading), justify="right", overflow="fold", min_width=width)
    for result in results:
        table.add_row(
            result.strategy,
            result.status.name.lower().replace("_", " "),
            str(result.iterations),
            f"{result.residual:.1e}",
            f"{result.largest_rise:.0e}" if result.largest_rise else "never",
            f"{result.H:.1f}",
            f"{result.joint_clearance:.3f}",
            f"{result.link_clearance:.3f}",
            f"{1e6 * result.step_seconds:.1f}",
        )
    if any(result.status is Status.COMPROMISE for result in results):
        table.caption = f"compromise: {Status.COMPROMISE.value}"
    return table


def write_results(file: Path, scene: Scene, path_result: PathResult, strategies: Sequence[StrategyResult]) -> Path:
    """Write all measurements and the scene as JSON; lengths [m], angles [rad], times [s]."""
    document: dict[str, Any] = {
        "machine": f"{platform.machine()}, Python {platform.python_version()}",
        "scene": {
            "robot": repr(scene.robot),
            "start": list(scene.start),
            "obstacles": [{"center": o.center.tolist(), "radius": o.radius} for o in scene.obstacles],
            "weights": {"joint_centering": scene.centering, "obstacle_avoidance": scene.avoidance},
        },
        "path": {
            "targets": len(path_result.q),
            "reached": path_result.reached,
            "largest_residual": float(path_result.residuals.max()),
            "smallest_joint_clearance": float(path_result.joint_clearance.min()),
            "smallest_link_clearance": float(path_result.link_clearance.min()),
            "mean_iterations": float(path_result.iterations.mean()),
            "step_seconds": path_result.step_seconds,
            "statuses": [status.name for status in path_result.statuses],
            "q": path_result.q.tolist(),
        },
        "strategies": [{**vars(result), "status": result.status.name, "q": result.q.tolist()} for result in strategies],
    }
    file.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
    return file
