"""Constructors whose errors list their arguments.

A call that does not fit the arguments of a constructor is a bare TypeError of Python, which names what is wrong and not
what is accepted. With this metaclass, or with `lists_arguments` on a function, it is a `CallError`. A call
that fits costs nothing but one more call.
"""

from __future__ import annotations

import functools
import inspect
from abc import ABCMeta
from collections.abc import Callable, Mapping
from inspect import Parameter, Signature
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

from jtik.errors import CallError

F = TypeVar("F", bound=Callable[..., Any])


if TYPE_CHECKING:
    _Base = ABCMeta
else:
    _Base = type(Protocol)


class Constructed(_Base):
    """Metaclass of a class that lists the arguments of its constructor for a call that does not fit them.

    A class of a user may have a `typing.Protocol` or an `abc.ABC` as another base.
    """

    # the isinstance of an abstract class; that of a protocol asks for attributes, which other classes lack
    __instancecheck__ = ABCMeta.__instancecheck__
    __subclasscheck__ = ABCMeta.__subclasscheck__

    if not TYPE_CHECKING:  # a type checker reads the constructor itself

        def __call__(cls, *args, **kwargs):  # noqa: N805
            """Make an object, or say what the constructor accepts."""
            try:
                return super().__call__(*args, **kwargs)
            except TypeError:
                error = _misfit(cls.__name__, cls.__signature__, args, kwargs, _alternatives(cls))
                if error is None:  # it comes from within
                    raise
            raise error

        @property
        def __signature__(cls) -> Signature:  # noqa: N805
            """The arguments of the constructor, for `inspect.signature`, which would show those of ``__call__``."""
            if cls.__init__ is not object.__init__:
                return _bound(cls.__init__)
            return Signature() if cls.__new__ is object.__new__ else _bound(cls.__new__)


def lists_arguments(function: F) -> F:
    """Decorate a function, or a class method below ``@classmethod``, that builds an object.

    Args:
        function: the function.
    """
    is_method = next(iter(inspect.signature(function).parameters), "") == "cls"

    @functools.wraps(function)
    def called(*args: Any, **kwargs: Any) -> Any:
        try:
            return function(*args, **kwargs)
        except TypeError:
            owner = f"{args[0].__name__}." if is_method else ""
            signature = _bound(function) if is_method else inspect.signature(function)
            error = _misfit(owner + function.__name__, signature, args[is_method:], kwargs, {})
            if error is None:
                raise
        raise error

    return called  # type: ignore[return-value]


def _bound(function: Callable[..., Any]) -> Signature:
    """The signature without the first parameter."""
    _, *parameters = inspect.signature(function).parameters.values()
    return Signature(parameters)


def _misfit(
    name: str,
    signature: Signature,
    args: tuple[Any, ...],
    kwargs: Mapping[str, Any],
    alternatives: Mapping[str, Signature],
) -> CallError | None:
    """The error for arguments that a signature does not fit; None for those that it fits."""
    try:
        signature.bind(*args, **kwargs)
    except TypeError as error:
        problem = str(error)
    else:
        return None
    parameters = signature.parameters
    unknown = [each for each in kwargs if each not in parameters]
    accepted = f"{name}({_listed(signature)})"
    for other, arguments in alternatives.items():
        if not set(kwargs).isdisjoint(arguments.parameters):
            accepted += f" or {other}({_listed(arguments)})"
    if not unknown:
        missing = problem.removeprefix("missing a required argument: ")
        return CallError(name, f"no {missing}" if missing != problem else problem, accepted)
    import difflib

    close = [match for each in unknown for match in difflib.get_close_matches(each, parameters, n=1)]
    hint = f"; did you mean {' and '.join(close)}?" if close else ""
    return CallError(", ".join(unknown), f"to {name}, which has no argument of this name", accepted + hint)


def _alternatives(cls: type) -> dict[str, Signature]:
    """The class methods that make an object of the class, by their names."""
    found = {}
    for name in dir(cls):
        method = inspect.getattr_static(cls, name)
        made = method.__func__ if isinstance(method, classmethod) and name[0] != "_" else None
        if inspect.isfunction(made) and made.__annotations__.get("return") in ("Self", cls.__name__):
            found[f"{cls.__name__}.{name}"] = _bound(made)
    return found


def _listed(signature: Signature) -> str:
    """The names of arguments, those that may be left out with an equals sign and dots."""
    shown = []
    for each in signature.parameters.values():
        if each.kind in (Parameter.VAR_POSITIONAL, Parameter.VAR_KEYWORD):
            continue
        shown.append(each.name if each.default is Parameter.empty else f"{each.name}=...")
    return ", ".join(shown)
