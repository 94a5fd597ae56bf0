"""One call with one value of the table, and what it shows."""

from __future__ import annotations

import warnings
from typing import Any, NamedTuple

import jtik
from jtik.qp.backend import BackendError

from .surface import ENTRIES
from .values import VALUES

OF_NAMES = (jtik.RobotFileError, BackendError)
"""Errors that name a file or a solver, not an argument."""

CALLED = {
    "value": "_",  # that of a live parameter, such as joint_centering.weight
    "vehicle_lower": "'x'",
    "vehicle_upper": "'x'",
    "vehicle_velocity_limit": "'x'",
    "rows": "o",  # rows, or the joints of which none moves
    "plugin": "criterion",
    "criterion": "case",
}
"""Arguments for which an error has another name: that of the joint or of the parameter."""


class Fault(NamedTuple):
    """A call that ended otherwise than the table says.

    Attributes:
        what: "raw error", "wrong acceptance", "wrong refusal" or "argument not named".
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
        shown = f"{type(error).__name__}: {error}"
        if accepted:
            return Fault("wrong refusal", call, shown)
        named = (
            isinstance(error, (jtik.UnknownNameError, *OF_NAMES))
            or argument in shown
            or CALLED.get(argument, argument) in shown
        )
        return None if named else Fault("argument not named", call, shown)
    except Exception as error:
        return Fault("raw error", call, f"{type(error).__name__}: {error}")
    return None if accepted else Fault("wrong acceptance", call)
