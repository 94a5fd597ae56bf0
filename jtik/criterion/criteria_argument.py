"""What ``criteria=`` accepts: criteria by their registered names, and hints for what is no criterion."""

from __future__ import annotations

import importlib
import inspect
from typing import Any

from jtik.errors import ArgumentError


def registered(name: str) -> Any:
    """A registered criterion with its default arguments.

    Raises:
        ArgumentError: when its class needs arguments.
        UnknownNameError: when no criterion is registered under the name.
    """
    # by name at run time, since the registry imports this module
    plugin: Any = importlib.import_module("jtik.registry").criteria[name]
    missing = required_arguments(plugin)
    if missing:
        call = f"{', '.join(f'{argument}=...' for argument in missing)})"
        accepted = f"an object: jtik.criteria[{name!r}]({call}, that is {plugin.__name__}({call}"
        raise ArgumentError("criteria", f"{name!r}, whose class needs {' and '.join(missing)}", accepted)
    return plugin()


def required_arguments(plugin: Any) -> list[str]:
    """Names of the arguments of a class that have no default."""
    return [
        name
        for name, parameter in inspect.signature(plugin).parameters.items()
        if parameter.default is parameter.empty
        and parameter.kind not in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD)
    ]


def hint(given: Any, base: type) -> tuple[Any, str]:
    """What was given and what is accepted, for something that is no criterion."""
    accepted = "a jtik.Criterion, a weighted sum, the name of a registered criterion, a list of these, or None"
    if isinstance(given, type) and issubclass(given, base):
        arguments = ", ".join(f"{name}=..." for name in required_arguments(given))
        return f"the class {given.__name__}", f"an object of it, {given.__name__}({arguments}); or {accepted}"
    if inspect.isfunction(given):
        return f"the function {given.__name__}", f"the function with the decorator @jtik.criterion; or {accepted}"
    return given, accepted
