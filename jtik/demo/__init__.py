"""The demo: Figure 2.2 of Das, Slotine and Sheridan (1988) as a picture, as an animation and in numbers.

The end effector of a ten-link planar arm follows a path through a field of discs. The criteria are obstacle avoidance
and zero joint angles. Then every registered strategy solves the last target from the same start.
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
    """What the demo measured, and the files it wrote.

    Attributes:
        path: the path through the field.
        without: the same path without obstacle avoidance.
        strategies: one solve for each registered strategy.
        files: the files.
    """

    path: PathResult
    without: PathResult
    strategies: tuple[StrategyResult, ...]
    files: tuple[Path, ...]


def run(out: str | Path = "jtik-demo", *, quick: bool = False, console: Console | None = None) -> DemoResult:
    """Run the demo and write its files.

    Args:
        out: folder for postures.png, postures.svg, arm.gif and results.json; it is created if necessary.
        quick: whether to use fewer targets, frames and repetitions.
        console: where to show progress and tables; None to show nothing.

    Raises:
        MissingExtraError: when rich, matplotlib or pillow is not installed.
        OSError: when the folder cannot be written.
    """
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    targets, frames, runs = (36, 12, 3) if quick else (121, 61, 15)
    scene = Scene()
    positions = scene.path(targets)
    names = list(strategies)
    with _progress(console) as progress:
        task = progress.add_task("following the path", total=targets)
        path = follow_path(scene, positions, advance=lambda: progress.advance(task))
        task = progress.add_task("without avoidance", total=targets)
        without = follow_path(scene, positions, avoid=False, advance=lambda: progress.advance(task))
        task = progress.add_task("every strategy", total=len(names))
        tried = []
        for name in names:
            tried.append(try_strategy(scene, name, positions[-1], runs))
            progress.advance(task)
        task = progress.add_task("pictures", total=3)
        files = draw_stills(scene, path.q, without.q, folder)
        progress.advance(task)
        files.append(animate(scene, path.q, folder / "arm.gif", frames))
        progress.advance(task)
        files.append(write_results(folder / "results.json", scene, path, tried))
        progress.advance(task)
    if console is not None:
        console.print(path_table(path), strategy_table(tried), sep="\n")
        console.print(f"written: {', '.join(str(file) for file in files)}", soft_wrap=True, markup=False)
    return DemoResult(path, without, tuple(tried), tuple(files))


def _progress(console: Console | None) -> Any:
    """Progress bars on the console."""
    try:
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
    except ImportError as error:
        raise MissingExtraError("rich", "cli", "the demo") from error
    columns = (TextColumn("{task.description:<20}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    return Progress(*columns, console=console, disable=console is None)
