"""Plugins of third parties: classes that a distribution names in an entry-point group."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from jtik.errors import JtikError

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint


class PluginError(JtikError):
    """A third party's plugin that could not be loaded.

    Attributes:
        plugin: its name.
        distribution: the distribution that names it.
        reason: what went wrong.
    """

    def __init__(self, plugin: str, distribution: str, reason: str) -> None:
        super().__init__(plugin, distribution, reason)
        self.plugin = plugin
        self.distribution = distribution
        self.reason = reason

    def __str__(self) -> str:
        return f"plugin {self.plugin!r} of distribution {self.distribution!r} could not be loaded: {self.reason}"


class Plugins:
    """The entry points of one group. Each is loaded at most once, unless its own name is looked up again.

    Args:
        group: the entry-point group.
        add: registers a loaded class under a name; what it raises is the plugin's fault.
    """

    def __init__(self, group: str, add: Callable[[str, object], None]) -> None:
        self._group = group
        self._add = add
        self._found: tuple[EntryPoint, ...] | None = None
        self._loading: set[EntryPoint] = set()
        self._loaded: set[EntryPoint] = set()
        self._broken: dict[EntryPoint, PluginError] = {}

    @property
    def _entries(self) -> tuple[EntryPoint, ...]:
        """The group's entry points, read from the installed distributions when they are first needed."""
        if self._found is None:
            from importlib.metadata import entry_points  # takes as long to load as NumPy's linear algebra

            self._found = tuple(sorted(entry_points(group=self._group), key=lambda entry: (entry.name, entry.value)))
        return self._found

    @property
    def broken(self) -> tuple[PluginError, ...]:
        """What was tried and could not be loaded, by name."""
        return tuple(self._broken[entry] for entry in self._entries if entry in self._broken)

    @property
    def untried(self) -> tuple[str, ...]:
        """Names that have not been looked up yet."""
        return tuple(entry.name for entry in self._entries if entry not in self._loaded and entry not in self._broken)

    def load_all(self) -> None:
        """Load what was not tried yet. Raises nothing: see `broken`."""
        for entry in self._entries:
            if entry not in self._loaded and entry not in self._broken:
                self._load(entry)

    def load(self, name: object) -> PluginError | None:
        """Load the plugins of one name, and try a broken one again.

        Returns:
            What is wrong with the first that could not be loaded; None where all could, or there is none.
        """
        entries = [entry for entry in self._entries if entry.name == name]
        for entry in entries:
            if entry not in self._loaded:
                self._load(entry)
        return next((self._broken[entry] for entry in entries if entry in self._broken), None)

    def _load(self, entry: EntryPoint) -> None:
        """Load and register one; a plugin may raise anything, and may even exit."""
        if entry in self._loading:  # its own module lists what is registered
            return
        self._loading.add(entry)
        try:
            self._add(entry.name, entry.load())
        except (Exception, SystemExit) as error:
            distribution = entry.dist.name if entry.dist else "unknown"
            reason = PluginError(entry.name, distribution, f"{type(error).__name__}: {error}")
            reason.__cause__ = error
            self._broken[entry] = reason
        else:
            self._broken.pop(entry, None)
            self._loaded.add(entry)
        finally:
            self._loading.discard(entry)
