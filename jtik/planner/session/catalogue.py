"""What the operator can choose by name: strategies with their options, and criteria; those of third parties, too."""

from __future__ import annotations

import inspect
import math
import typing
import warnings
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Annotated, Any, Literal, get_args, get_origin

from jtik.criterion import Criterion
from jtik.criterion.criteria_argument import required_arguments
from jtik.errors import ArgumentError, UnknownNameError
from jtik.registry import criteria, secondaries, strategies, strategy_of
from jtik.strategy import Strategy

SECONDARY = "secondary."
"""What the name of an option of a strategy's secondary term begins with."""

Make = Callable[..., Criterion]


def strategy_entries() -> tuple[dict[str, Any], ...]:
    """Name, summary and options of every strategy with defaults, alone and with every secondary term."""
    found = []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # of a plugin that cannot be loaded, which the listing leaves out
        known, terms = dict(strategies), dict(secondaries)
    for name, registered in known.items():
        pairs = [f"{name}+{term}" for term in terms] if "secondary" in _fields(registered) else []
        for each in (name, *pairs):
            try:
                made = strategy_of(each)
            except Exception:  # a class of a third party may raise anything; a pair that does not go together
                continue
            found.append({"name": each, "summary": registered.summary, "options": _options(made)})
    return tuple(found)


def strategy(name: str, options: Mapping[str, Any]) -> Strategy:
    """The strategy of a name with options; None as the value of a number stands for infinity.

    Raises:
        UnknownNameError: for a name that is not registered.
        ArgumentError: for an option that the strategy does not have, or a value that it does not accept.
    """
    made = strategy_of(name)
    known = {entry["name"]: entry for entry in _options(made)}
    own, inner = dict[str, Any](), dict[str, Any]()
    for option, value in options.items():
        if option not in known:
            raise ArgumentError(option, value, f"an option of {name}: {', '.join(known) or 'it has none'}")
        infinite = value is None and known[option]["type"] == "number"
        values = inner if option.startswith(SECONDARY) else own
        values[option.removeprefix(SECONDARY)] = math.inf if infinite else value
    if inner:
        own["secondary"] = replace(made.secondary, **inner)  # type: ignore[attr-defined]  # since it has such options
    return replace(made, **own) if own else made  # type: ignore[type-var]  # since it has fields


def _options(made: Any) -> tuple[dict[str, Any], ...]:
    """Name, type, value and choices of each plain option of a strategy, and of its secondary term."""
    found, hints = [], _hints(type(made))
    for name in _fields(type(made)):
        value = getattr(made, name)
        choices = _choices(hints.get(name))
        kind = _kind(value, choices)
        if kind:
            found.append({"name": name, "type": kind, "value": value, "choices": choices})
    term = getattr(made, "secondary", None)
    found += [{**entry, "name": SECONDARY + entry["name"]} for entry in (_options(term) if is_dataclass(term) else ())]
    return tuple(found)


def _fields(kind: type) -> list[str]:
    return [field.name for field in fields(kind) if field.init] if is_dataclass(kind) else []


def _kind(value: Any, choices: tuple[str, ...]) -> str:
    if choices:
        return "choice"
    if isinstance(value, bool):
        return "flag"
    if isinstance(value, int):
        return "integer"
    return "number" if isinstance(value, float) else ""


def _hints(kind: type) -> Mapping[str, Any]:
    try:
        return typing.get_type_hints(kind, include_extras=True)
    except Exception:  # a name that only a type checker knows
        return {}


def _choices(annotation: Any) -> tuple[str, ...]:
    """The words of an option that is one of a few."""
    if get_origin(annotation) is Annotated:
        annotation = get_args(annotation)[0]
    found = get_args(annotation) if get_origin(annotation) is Literal else ()
    return tuple(found) if all(isinstance(each, str) for each in found) else ()


class Criteria:
    """The criteria that can be chosen: the registered ones with defaults, and those that were given as objects.

    Args:
        given: criteria by name, beside the registered ones.
    """

    def __init__(self, given: Mapping[str, Criterion] | None = None) -> None:
        self._given = dict(given or {})

    def names(self) -> tuple[str, ...]:
        """The names that can be chosen."""
        return tuple(entry["name"] for entry in self.entries())

    def entries(self) -> tuple[dict[str, Any], ...]:
        """Name and summary of each criterion that can be chosen, and whether it keeps away from the obstacles."""
        found = {}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # of a plugin that cannot be loaded
            known = dict(criteria)
        for name, kind in known.items():
            required = [each for each in required_arguments(kind) if each != "obstacles"]
            if not required and not inspect.isabstract(kind):
                found[name] = {"name": name, "summary": kind.summary, "obstacles": takes_obstacles(kind)}
        for name, criterion in self._given.items():
            found[name] = {"name": name, "summary": type(criterion).summary or repr(criterion), "obstacles": False}
        return tuple(found.values())

    def make(self, name: str, obstacles: Mapping[str, Any]) -> Criterion:
        """A criterion.

        Args:
            name: its name.
            obstacles: arguments for one that keeps away from obstacles.

        Raises:
            UnknownNameError: for a name that cannot be chosen.
            ArgumentError: for one that needs arguments.
        """
        if name in self._given:
            return self._given[name]
        return self.registered(name, obstacles)

    def registered(self, name: str, obstacles: Mapping[str, Any]) -> Criterion:
        """The registered criterion of a name; arguments and errors as of `make`."""
        if name not in criteria:
            raise UnknownNameError("criterion", name, self.names())
        kind: Any = criteria[name]
        required = [each for each in required_arguments(kind) if each != "obstacles"]
        if required:
            accepted = f"a criterion without arguments, one of {', '.join(self.names())}; or an object from Python"
            raise ArgumentError("criteria", f"{name!r}, which needs {' and '.join(required)}", accepted)
        if not takes_obstacles(kind):
            made: Criterion = kind()
            return made
        wanted = inspect.signature(kind).parameters
        made = kind(**{key: value for key, value in obstacles.items() if key in wanted})
        return made


def takes_obstacles(kind: type) -> bool:
    """Whether a class of criteria has the argument ``obstacles``."""
    return "obstacles" in inspect.signature(kind).parameters
