"""Errors of jtik.

Every error derives from `JtikError`, so ``except JtikError`` catches all of them and nothing else. Each keeps its data
as attributes. Its message contains what would have been accepted.
"""

from __future__ import annotations

from collections.abc import Iterable


class JtikError(Exception):
    """Base class of the errors that jtik raises."""


class ArgumentError(JtikError, ValueError):
    """An argument has a value that cannot be used.

    Attributes:
        argument: name of the argument, as the caller wrote it.
        given: what was given, or a text that describes it.
        accepted: what would have been accepted.
    """

    def __init__(self, argument: str, given: object, accepted: str) -> None:
        super().__init__(argument, given, accepted)
        self.argument = argument
        self.given = given
        self.accepted = accepted

    def __str__(self) -> str:
        shown = self.given if isinstance(self.given, str) else _shown(self.given)
        return f"{self.argument}: given {shown}; accepted: {self.accepted}"


class CallError(ArgumentError, TypeError):
    """A call that does not fit the arguments of a constructor: an unknown name, or one that is missing.

    Attributes:
        argument: the unknown names; otherwise what was called.
        given: what does not fit.
        accepted: what was called, with its arguments, and other ways to make the same object.
    """


class UnknownNameError(JtikError, KeyError):
    """A name that does not exist: of a frame, a joint, a strategy ...

    Attributes:
        kind: what was looked up, for instance ``"frame"``.
        name: the name that was not found.
        known: the names that exist.
        closest: the known name most similar to the given one, without regard to case; None if none is similar.
        nearest: up to three known names that are similar, the most similar first.
        hint: what else helps, such as the name of the tip; the message then has all of ``nearest``. Empty without one.
    """

    def __init__(self, kind: str, name: str, known: Iterable[str], hint: str = "") -> None:
        import difflib

        self.kind = kind
        self.name = name
        self.known = tuple(known)
        lowered = {str(one).lower(): one for one in reversed(self.known)}
        matches = difflib.get_close_matches(str(name).lower(), lowered, n=3)
        self.nearest = tuple(lowered[match] for match in matches)
        self.closest: str | None = self.nearest[0] if self.nearest else None
        self.hint = hint
        super().__init__(kind, name, self.known, hint)

    def __str__(self) -> str:
        nearest = " or ".join(map(repr, self.nearest if self.hint else self.nearest[:1]))
        hint = f"; did you mean {nearest}?" if nearest else ""
        listed = ", ".join(self.known) if self.known else "none"
        more = f"; {self.hint}" if self.hint else ""
        return f"unknown {self.kind} {self.name!r}{hint}{more} (known: {listed})"


class MissingExtraError(JtikError, ImportError):
    """A feature needs an optional package that is not installed.

    Attributes:
        package: the package that is missing.
        extra: the extra of jtik that installs it.
        feature: the feature that needs the package.
    """

    def __init__(self, package: str, extra: str, feature: str) -> None:
        self.package = package
        self.extra = extra
        self.feature = feature
        super().__init__(package, extra, feature)

    def __str__(self) -> str:
        return f"{self.feature} needs {self.package}; install it with: pip install 'jtik[{self.extra}]'"


class RobotFileError(JtikError, ValueError):
    """A robot description that cannot be read.

    Attributes:
        file: the path; for a description that is a text or a model, what kind it is.
        element: the part that is wrong, for instance ``"joint 'elbow'"``; empty for the description as such.
        problem: what is wrong, and what would have been accepted.
    """

    def __init__(self, file: str, element: str, problem: str) -> None:
        super().__init__(file, element, problem)
        self.file = file
        self.element = element
        self.problem = problem

    def __str__(self) -> str:
        return ": ".join(part for part in (self.file, self.element, self.problem) if part)


class ImmutableError(JtikError, AttributeError):
    """An attempt to change an object that cannot change.

    Attributes:
        owner: the object, as text.
        attribute: the attribute that the caller tried to set or delete.
        instead: what to do instead.
    """

    def __init__(self, owner: str, attribute: str, instead: str = "build a new one") -> None:
        self.owner = owner
        self.attribute = attribute
        self.instead = instead
        super().__init__(owner, attribute, instead)

    def __str__(self) -> str:
        return f"{self.owner} is immutable: {self.attribute!r} cannot be changed; {self.instead} instead"


LONGEST_SHOWN = 1000
"""Length at which the text of a value is cut in a message."""

LONGEST_ARRAY = 120
"""The same for an array, of which a message then has the shape, too."""


def _shown(value: object) -> str:
    """The text of a value in a message, whatever its ``repr`` raises or returns."""
    try:
        shown, shape = repr(value), getattr(value, "shape", None)
    except Exception:  # such as that of an integer of very many digits
        return f"<{type(value).__name__}>"
    if isinstance(shape, tuple):
        shown = " ".join(shown.split())  # one line
        if len(shown) > LONGEST_ARRAY:
            return f"shape {shape}, {shown[:LONGEST_ARRAY]}..."
    return shown if len(shown) <= LONGEST_SHOWN else f"{shown[:LONGEST_SHOWN]}..."
