"""One call with one value of the table, and what it shows."""

from __future__ import annotations

import warnings
from typing import Any, NamedTuple

import jtik

from .surface import ENTRIES
from .values import VALUES


class Fault(NamedTuple):
    """A call that ended otherwise than the table says.

    Attributes:
        what: "raw error", "wrong acceptance" or "wrong refusal".
        call: the call, as a text.
        shown: the error, as a text.
    """

    what: str
    call: str
    shown: str = ""


def faults(name: str) -> tuple[int, list[Fault]]:
    """The number of calls of one entry, and the faults among them."""
    entry, count, found = ENTRIES[name], 0, list[Fault]()
    for argument, kind in entry.kinds.items():
        for label, make in VALUES.items():
            if label in kind.skipped:
                continue
            count += 1
            fault = _fault(f"{name}({argument}={label})", entry, argument, make(), label in kind.accepted)
            if fault is not None:
                found.append(fault)
    return count, found


def _fault(call: str, entry: Any, argument: str, value: object, accepted: bool) -> Fault | None:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            entry.call(**{**entry.given(), argument: value})
    except jtik.JtikError as error:
        return Fault("wrong refusal", call, f"{type(error).__name__}: {error}") if accepted else None
    except Exception as error:
        return Fault("raw error", call, f"{type(error).__name__}: {error}")
    return None if accepted else Fault("wrong acceptance", call)
