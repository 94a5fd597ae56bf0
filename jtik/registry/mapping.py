"""A mapping from name to class, each of which is loaded when it is looked up."""

from __future__ import annotations

import importlib.util
import warnings
from collections.abc import Callable, Iterator, Mapping
from typing import Any, Generic, TypeVar

from jtik.errors import ArgumentError, UnknownNameError
from jtik.registry import table
from jtik.registry.plugins import PluginError, Plugins

BUILT_IN = "jtik_formulations"

T = TypeVar("T")
C = TypeVar("C", bound=type)


class Registry(Mapping[str, type[T]], Generic[T]):
    """A mapping from name to class, which shows itself as a table of name, summary and source.

    The name of a built-in class loads no code of third parties, and the name of a third party's class loads that class
    only. What lists all names (iteration, ``len``, ``repr``) loads all plugins. A plugin that cannot be loaded is
    left out: the first listing in a process warns of it, and only its own name raises PluginError. The name of a
    built-in class loads its module alone where that has the same name.

    Args:
        kind: what the classes are, for errors.
        base: the class that all of them derive from.
        group: the entry-point group in which distributions name theirs.
        modules: names of the modules that may have the built-in class of a name, ``{}``.
    """

    def __init__(self, kind: str, base: type, group: str, modules: tuple[str, ...] = ()) -> None:
        self._kind = kind
        self._base: type[Any] = base
        self._title = group.rpartition(".")[2]
        self._modules = modules
        self._classes: dict[str, type[T]] = {}
        self._plugins = Plugins(group, self.add)
        self._warned: set[tuple[str, str]] = set()

    def add(self, name: str, plugin: Any) -> None:
        """Register a class. The same class again, by module and qualified name, replaces the former one.

        Args:
            name: the name to register it by.
            plugin: the class.

        Raises:
            ArgumentError: when another class has the name, the name cannot be used, or ``plugin`` is no subclass of the
                base.
        """
        self.check_name(name)
        if not (isinstance(plugin, type) and issubclass(plugin, self._base)):
            raise ArgumentError(f"{self._kind} {name!r}", plugin, f"a subclass of {self._base.__name__}")
        if plugin.__module__.partition(".")[0] != BUILT_IN:
            self._load_built_in()  # whose names are taken
        known = self._classes.get(name)
        if known is not None and _identity(known) != _identity(plugin):
            given = f"{name!r} for {_identity(plugin)}"
            raise ArgumentError(f"{self._kind} name", given, f"a name not yet taken by {_identity(known)}")
        self._classes[name] = plugin
        if not vars(plugin).get("name"):
            plugin.name = name  # type: ignore[attr-defined]

    def register(self, name: str) -> Callable[[C], C]:
        """A class decorator that adds a class by this name, with the errors of `add`.

        Args:
            name: name under which the class is found.
        """
        self.check_name(name)  # also finds a decorator without its name

        def registered(plugin: C) -> C:
            self.add(name, plugin)
            return plugin

        return registered

    def check_name(self, name: object) -> None:
        """Raise ArgumentError when ``name`` is no text that a listing can show, or has the ``+`` of pairs.

        Args:
            name: the name.
        """
        if not isinstance(name, str) or not name.strip() or not name.isprintable() or "+" in name:
            raise ArgumentError(f"{self._kind} name", repr(name), "a text of at least one character, without '+'")

    def __getitem__(self, name: str) -> type[T]:
        error = self._load(name)
        if name in self._classes:
            return self._classes[name]
        raise error or UnknownNameError(self._kind, name, self.names())

    def __contains__(self, name: object) -> bool:
        error = self._load(name)
        if name in self._classes:
            return True
        self._warn(() if error is None else (error,), stacklevel=3)
        return False

    def __iter__(self) -> Iterator[str]:
        self._load_all()
        return iter(sorted(self._classes))

    def __len__(self) -> int:
        self._load_all()
        return len(self._classes)

    def __repr__(self) -> str:
        self._load_all()
        return table.text_table(*self._table())

    def _repr_html_(self) -> str:
        self._load_all()
        return table.html_table(*self._table())

    def loaded(self) -> Mapping[str, type[T]]:
        """The built-in classes and what else is loaded by now, by name; loads no code of third parties."""
        self._load_built_in()
        return {name: self._classes[name] for name in sorted(self._classes)}

    def names(self) -> list[str]:
        """All names, sorted; no code of third parties is loaded."""
        self._load_built_in()
        return sorted({*self._classes, *self._plugins.untried})

    def rows(self) -> list[table.TableRow]:
        """The rows of the table. A plugin that cannot be loaded has a row with the reason; there is no warning."""
        self._load_built_in()
        self._plugins.load_all()
        broken = [
            table.TableRow(error.plugin, f"could not be loaded: {' '.join(error.reason.split())}", error.distribution)
            for error in self._plugins.broken
        ]
        return sorted([*table.rows(self._classes), *broken])

    def _table(self) -> tuple[str, list[table.TableRow]]:
        rows = self.rows()
        broken = len(rows) - len(self._classes)
        return f"{self._title}: {len(self._classes)}{f', and {broken} broken' if broken else ''}", rows

    def _load_built_in(self) -> None:
        package = importlib.import_module(BUILT_IN)
        for name in package.__all__:
            getattr(package, name)

    def _load_module(self, name: object) -> None:
        """Import the module of a built-in class where it has the name of the class."""
        if isinstance(name, str) and name.isidentifier() and name not in self._classes:
            for module in self._modules:
                wanted = f"{BUILT_IN}.{module.format(name)}"
                if importlib.util.find_spec(wanted):
                    importlib.import_module(wanted)

    def _load(self, name: object) -> PluginError | None:
        """Load the class of one name if it is not loaded yet. Returns the error of a plugin, or None."""
        self._load_module(name)
        if name in self._classes:
            return None
        self._load_built_in()
        return None if name in self._classes else self._plugins.load(name)

    def _load_all(self) -> None:
        """Load everything. Warns of what cannot be loaded."""
        self._load_built_in()
        self._plugins.load_all()
        self._warn(self._plugins.broken)

    def _warn(self, errors: tuple[PluginError, ...], stacklevel: int = 4) -> None:
        """Warn the caller's caller, once for each plugin in a process."""
        for error in errors:
            key = (error.plugin, error.distribution)
            if key not in self._warned:
                self._warned.add(key)
                warnings.warn(f"{error}; it is left out of the {self._title}", UserWarning, stacklevel=stacklevel)


def _identity(plugin: type) -> str:
    """What makes a class the same one when its definition runs again."""
    return f"{plugin.__module__}.{plugin.__qualname__}"
