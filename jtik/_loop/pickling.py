"""How solvers and studies are sent to other processes."""

from __future__ import annotations

import importlib
import pickle
from typing import Any

PICKLABLE = (
    "classes and functions defined at the top level of a module, which another process can import; "
    "or install cloudpickle, which also supports lambdas and those defined in a notebook"
)


def pickler() -> Any:
    """The module that pickles: cloudpickle where it is installed."""
    try:
        return importlib.import_module("cloudpickle")
    except ImportError:
        return pickle
