"""Progress of long computations: a bar on the terminal, or calls of a function."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Protocol, TypeVar

from jtik.arguments import flag
from jtik.errors import MissingExtraError

Item = TypeVar("Item")
Item_co = TypeVar("Item_co", covariant=True)
Progress = bool | Callable[[int, int], None]
"""False for none, True for a bar on the terminal, or a function that is called with (done, total)."""


class Counted(Protocol[Item_co]):
    """Items whose number is known."""

    def __len__(self) -> int: ...
    def __iter__(self) -> Iterator[Item_co]: ...


def read_progress(progress: object) -> Progress:
    """The argument ``progress`` of a long call.

    Args:
        progress: True, False, or a function.

    Raises:
        ArgumentError: for anything else.
    """
    if callable(progress):
        return progress
    return flag("progress", progress, "whether there is a bar on the terminal; or a function of (done, total)")


def watched(items: Counted[Item], progress: Progress, label: str) -> Iterator[Item]:
    """The items one by one; after each, ``progress`` is informed.

    Args:
        items: the items.
        progress: False for none, True for a bar on the terminal, or a function that is called with (done, total).
        label: text beside the bar.

    Raises:
        ArgumentError: when ``progress`` is something else.
        MissingExtraError: when a bar is wanted and rich is not installed.
    """
    if callable(progress):
        return _reported(items, progress)
    return _bar(items, label) if read_progress(progress) is True else iter(items)


@contextmanager
def counted(progress: Progress, label: str) -> Iterator[Callable[[int, int], None] | None]:
    """A function that is to be called with (done, total), where the total may grow; None where nobody is informed.

    Args:
        progress: as in `watched`. The bar also shows the elapsed time, which goes on between two calls.
        label: text beside the bar.

    Raises:
        ArgumentError: when ``progress`` is something else.
        MissingExtraError: when a bar is wanted and rich is not installed.
    """
    if callable(progress):
        yield progress
    elif read_progress(progress) is False:
        yield None
    else:
        try:
            from rich.console import Console
            from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn
            from rich.progress import Progress as Bar
        except ImportError as error:
            raise MissingExtraError("rich", "cli", "a progress bar") from error
        columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn()
        with Bar(*columns, console=Console(stderr=True)) as bar:
            task = bar.add_task(label, total=None)
            yield lambda done, total: bar.update(task, completed=done, total=total)


def _bar(items: Counted[Item], label: str) -> Iterator[Item]:
    """The items with a bar on the terminal, on stderr: what is printed on stdout may be read by a program."""
    try:
        from rich.console import Console
        from rich.progress import track
    except ImportError as error:
        raise MissingExtraError("rich", "cli", "a progress bar") from error
    return iter(track(items, description=label, console=Console(stderr=True)))


def _reported(items: Counted[Item], report: Callable[[int, int], None]) -> Iterator[Item]:
    """The items; ``report`` is called after each."""
    for done, item in enumerate(items, start=1):
        yield item
        report(done, len(items))
