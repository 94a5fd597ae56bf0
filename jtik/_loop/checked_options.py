"""The options of a solve that have been checked: the next one with the same options need not check them again."""

from __future__ import annotations

from typing import Any

from jtik._loop.native.solves import NativeSolves
from jtik._loop.options import read_search_options, read_settings
from jtik._loop.search.search import Search, SearchOptions
from jtik.types import Array

Options = tuple[int, int | None, int, int, float | None, float, float, float, str]
"""restarts, seed, max_iterations, best_of, jump_limit, tolerances of position, orientation and optimality, until."""


class CheckedOptions:
    """The options of the last solve, whose tolerances are in memory.

    Args:
        search: the search, which is prepared for them.
        natives: solves in C, which are notified when they change.
        settings: the memory of the tolerances.
        has_criterion: whether there is a criterion; then the search in C alone is not enough.
    """

    def __init__(self, search: Search, natives: NativeSolves, settings: Array, *, has_criterion: bool) -> None:
        self._search, self._natives, self._settings, self._has_criterion = search, natives, settings, has_criterion
        self._options, self._kinds, self._prepared = tuple[Any, ...](), list[type](), tuple[Any, ...]()
        self._search_options, self._prepared_for = SearchOptions(0, 0, 0), search.native

    def forget(self) -> None:
        """Check the next ones in any case."""
        self._natives.forget_lanes()
        self._forget_search()

    def _forget_search(self) -> None:
        self._natives.forget()
        self._options, self._prepared, self._prepared_for = (), (), self._search.native

    def is_prepared(self, options: Options) -> bool:
        """Whether the search in C is prepared for these options."""
        return self._search.native is self._prepared_for and self._known(options, self._prepared, self._kinds)

    def read(self, options: Options) -> SearchOptions:
        """The options of a search; tolerances are written to memory. Both when they, or the search in C, are new.

        Raises:
            ArgumentError: for a value that cannot be used, naming it.
        """
        if not self._known(options, self._options, self._kinds) or self._search.native is not self._prepared_for:
            if not self._known(options[5:], self._options[5:], self._kinds[5:]):
                self._natives.forget_lanes()  # which have the same tolerances in memory
            self._forget_search()
            self._search_options = read_search_options(*options[:5])
            self._settings[:] = read_settings(*options[5:])
            self._options, self._kinds = options, [*map(type, options)]
            if not self._has_criterion and self._search.prepare(self._search_options):
                self._prepared = options
                self._natives.know(options)
        return self._search_options

    @staticmethod
    def _known(options: tuple[Any, ...], checked: tuple[Any, ...], kinds: list[type]) -> bool:
        """Whether the options are those that have been checked, of the same types: True equals 1, and is none."""
        return [*map(type, options)] == kinds and options == checked
