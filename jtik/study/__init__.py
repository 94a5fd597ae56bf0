"""Studies: strategies and other libraries on the same problems, measured in the same way.

`compare` runs a study and returns a `Comparison`. A `StrategyContender` sets options of one strategy in it. A solver of
your own takes part as a `Contender`, which `Contender.prepare` turns into a `PreparedContender`.
"""

import warnings
from typing import Any

from jtik.study.compare import compare
from jtik.study.comparison import Comparison
from jtik.study.contender import Answer, Contender, PreparedContender, Setting
from jtik.study.rows import Row
from jtik.study.strategies import StrategyContender

__all__ = [
    "Answer",
    "Comparison",
    "Contender",
    "PreparedContender",
    "Row",
    "Setting",
    "StrategyContender",
    "compare",
]

_RENAMED = {"Law": StrategyContender, "Ready": PreparedContender}


def __getattr__(name: str) -> Any:
    if name in _RENAMED:
        new = _RENAMED[name]
        warnings.warn(f"jtik.study.{name} is now jtik.study.{new.__name__}", DeprecationWarning, stacklevel=2)
        return new
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
