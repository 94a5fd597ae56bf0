"""Progress of long work, shown only when asked for."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Protocol, TypeVar

from jtik.errors import MissingExtraError

Item = TypeVar("Item")
Item_co = TypeVar("Item_co", covariant=True)
Progress = bool | Callable[[int, int], None]
"""True for a bar on the terminal, a function called with (done, total), or False for nothing."""


class Counted(Protocol[Item_co]):
    """Things to go through of which it is known how many they are."""

    def __len__(self) -> int: ...
    def __iter__(self) -> Iterator[Item_co]: ...


def watched(items: Counted[Item], progress: Progress, label: str) -> Iterator[Item]:
    """The items one by one, telling ``progress`` how many are done.

    Raises:
        MissingExtraError: for a bar without rich.
    """
    if progress is False:
        return iter(items)
    return _bar(items, label) if progress is True else _told(items, progress)


def _bar(items: Counted[Item], label: str) -> Iterator[Item]:
    try:
        from rich.progress import track
    except ImportError as error:
        raise MissingExtraError("rich", "cli", "a progress bar") from error
    return iter(track(items, description=label))


def _told(items: Counted[Item], tell: Callable[[int, int], None]) -> Iterator[Item]:
    for done, item in enumerate(items, start=1):
        yield item
        tell(done, len(items))
