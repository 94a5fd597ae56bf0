"""The repr of a criterion: its class and what was given."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from jtik import Criterion
from jtik.criterion.short_repr import call_text


def shown(criterion: Criterion, given: Mapping[str, object], defaults: Mapping[str, object]) -> str:
    """``Class(argument=value, ...)`` with the arguments that are not None and not at their defaults."""
    values = {}
    for argument, value in {**given, "name": criterion.name}.items():
        default = {"name": type(criterion).name, **defaults}.get(argument)
        if value is not None and not (default is not None and np.array_equal(np.asarray(value), np.asarray(default))):
            values[argument] = value
    return call_text(type(criterion).__name__, **values)
