"""Progress of long work, shown only when asked for."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

from jtik.errors import MissingExtraError

Item = TypeVar("Item")
Progress = bool | Callable[[int, int], None]
"""True for a bar on the terminal, a function called with (done, total), or False for nothing."""


def watched(items: Sequence[Item], progress: Progress, label: str) -> Iterator[Item]:
    """The items one by one, telling ``progress`` how many are done.

    Raises:
        MissingExtraError: for a bar without rich.
    """
    if progress is False:
        return iter(items)
    return _bar(items, label) if progress is True else _told(items, progress)


def _bar(items: Sequence[Item], label: str) -> Iterator[Item]:
    try:
        from rich.progress import track
    except ImportError as error:
        raise MissingExtraError("rich", "cli", "a progress bar") from error
    return iter(track(items, description=label))


def _told(items: Sequence[Item], tell: Callable[[int, int], None]) -> Iterator[Item]:
    for done, item in enumerate(items, start=1):
        yield item
        tell(done, len(items))
