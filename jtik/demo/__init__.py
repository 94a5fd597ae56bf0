"""The demo: Figure 2.2 of Das, Slotine and Sheridan (1988), drawn, measured and set in motion.

A ten-link planar arm follows a path of its tip through a field of discs while obstacle avoidance and zero joint angles
share the freedom left; then every registered strategy solves the last target from the same start.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from jtik.demo.measure import PathResult, StrategyResult, follow_path, try_strategy
from jtik.demo.pictures import animate, draw_stills
from jtik.demo.report import path_table, strategy_table, write_results
from jtik.demo.scene import Scene
from jtik.errors import MissingExtraError
from jtik.registry import strategies

if TYPE_CHECKING:
    from rich.console import Console

__all__ = ["DemoResult", "PathResult", "Scene", "StrategyResult", "run"]


@dataclass(frozen=True)
class DemoResult:
    """What the demo measured and the files it wrote.

    Attributes:
        path: the way through the field.
        without: the same way without obstacle avoidance.
        strategies: one solve a registered strategy.
        files: what was written.
    """

    path: PathResult
    without: PathResult
    strategies: tuple[StrategyResult, ...]
    files: tuple[Path, ...]


def run(out: str | Path = "jtik-demo", *, quick: bool = False, console: Console | None = None) -> DemoResult:
    """Run the demo and write its files.

    Args:
        out: folder for postures.png, postures.svg, arm.gif and results.json; made when it is missing.
        quick: fewer targets, frames and repetitions.
        console: where to show progress and tables; nothing is shown without one.

    Raises:
        MissingExtraError: without rich, matplotlib or pillow.
        OSError: when the folder cannot be written.
    """
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    targets, frames, runs = (36, 12, 3) if quick else (121, 61, 15)
    scene = Scene()
    path = scene.path(targets)
    names = list(strategies)
    with _progress(console) as progress:
        task = progress.add_task("following the path", total=targets)
        way = follow_path(scene, path, advance=lambda: progress.advance(task))
        task = progress.add_task("without avoidance", total=targets)
        without = follow_path(scene, path, avoid=False, advance=lambda: progress.advance(task))
        task = progress.add_task("every strategy", total=len(names))
        tried = []
        for name in names:
            tried.append(try_strategy(scene, name, path[-1], runs))
            progress.advance(task)
        task = progress.add_task("pictures", total=3)
        files = draw_stills(scene, way.q, without.q, folder)
        progress.advance(task)
        files.append(animate(scene, way.q, folder / "arm.gif", frames))
        progress.advance(task)
        files.append(write_results(folder / "results.json", scene, way, tried))
        progress.advance(task)
    if console is not None:
        console.print(path_table(way), strategy_table(tried), sep="\n")
        console.print(f"written: {', '.join(str(file) for file in files)}", soft_wrap=True, markup=False)
    return DemoResult(way, without, tuple(tried), tuple(files))


def _progress(console: Console | None) -> Any:
    try:
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
    except ImportError as error:
        raise MissingExtraError("rich", "cli", "the demo") from error
    columns = (TextColumn("{task.description:<20}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    return Progress(*columns, console=console, disable=console is None)
