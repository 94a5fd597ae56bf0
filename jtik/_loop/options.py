"""The options of a solve, checked before anything is computed."""

from __future__ import annotations

import math
import os
import sys
import warnings
from typing import TYPE_CHECKING, Literal, TypeAlias

from jtik._loop.search.search import SearchOptions
from jtik._step.inputs import Settings
from jtik.arguments import flag, integer, positive_number, positive_or_infinite
from jtik.errors import ArgumentError

if TYPE_CHECKING:
    from concurrent.futures import Executor

Until = Literal["stationary", "reached"]
Compiled: TypeAlias = bool | Literal["auto"]

ENVIRONMENT = "JTIK_COMPILED"
"""Environment variable: "off" keeps what is to be compiled by itself, with "auto", on the virtual machine."""


def read_settings(position: float, orientation: float, optimality: float, until: str) -> Settings:
    """Tolerances and when to stop.

    Raises:
        ArgumentError: for a value that cannot be used, naming it.
    """
    return Settings(
        positive_number("position_tolerance", position),
        positive_number("orientation_tolerance", orientation),
        positive_number("optimality_tolerance", optimality),
        1.0 if read_until(until) == "stationary" else 0.0,
    )


def read_rate(argument: str, rate: object) -> float:
    """A rate [1/s]: a positive number or infinity.

    Raises:
        ArgumentError: for anything else.
    """
    accepted = "a positive rate [1/s]; math.inf for steps as long as the strategy proposes"
    return positive_or_infinite(argument, rate, accepted)


def read_compiled(compiled: object) -> Compiled:
    """Whether the step runs as generated C: True, False, or "auto" for as soon as it is compiled.

    Raises:
        ArgumentError: for anything else, also of the environment variable.
    """
    if isinstance(compiled, str) and compiled == "auto":
        found = os.environ.get(ENVIRONMENT, "auto")
        if found not in ("auto", "off"):
            raise ArgumentError(f"the environment variable {ENVIRONMENT}", repr(found), "'auto' or 'off'")
        return "auto" if found == "auto" else False
    return flag("compiled", compiled, "whether the step runs as generated C, or 'auto' for as soon as it is compiled")


def read_until(until: str) -> Until:
    """When to stop; warns for the old name of "stationary".

    Raises:
        ArgumentError: for anything else.
    """
    if not isinstance(until, str):
        raise ArgumentError("until", repr(until), "'stationary' or 'reached'")
    if until == "stationary" or until == "reached":
        return until  # type: ignore[return-value]
    if until == "steady":
        message = 'until="steady" is deprecated: use until="stationary"'
        warnings.warn(message, DeprecationWarning, stacklevel=callers_level())
        return "stationary"
    raise ArgumentError("until", until, "'stationary' or 'reached'")


def callers_level() -> int:
    """The ``stacklevel`` of the first line outside this package, seen from the function that calls this one."""
    level, frame = 1, sys._getframe(1)
    while frame.f_back is not None and frame.f_globals.get("__name__", "").startswith("jtik."):
        level, frame = level + 1, frame.f_back
    return level


def read_search_options(
    restarts: int, seed: int | None, max_iterations: int, best_of: int = 1, jump_limit: float | None = None
) -> SearchOptions:
    """What a search may use.

    Raises:
        ArgumentError: for a value that cannot be used, naming it.
    """
    at_most = "a positive number [rad] or [m], or None for no limit"
    options = SearchOptions(
        limit=integer("max_iterations", max_iterations),
        restarts=integer("restarts", restarts),
        seed=0 if seed is None else integer("seed", seed),
        best_of=integer("best_of", best_of, minimum=1),
        jump_limit=math.inf if jump_limit is None else positive_number("jump_limit", jump_limit, at_most),
    )
    if options.best_of > 1 and not options.restarts:
        accepted = "1 without restarts; with restarts=100, for instance, any number of distinct configurations"
        raise ArgumentError("best_of", best_of, accepted)
    return options


def read_lanes(lanes: object, nearest: object, trace: object) -> tuple[bool, bool]:
    """Whether several starts of one solve are tried side by side, and whether the caller's own wins where it arrives.

    Raises:
        ArgumentError: for a value that cannot be used, naming it.
    """
    lanes = flag("lanes", lanes, "whether several starts are tried side by side in vector registers")
    nearest = flag("nearest", nearest, "whether the start q0 wins where it arrives, with lanes=True")
    if nearest and not lanes:
        raise ArgumentError("nearest", nearest, "False; True with lanes=True")
    if lanes and flag("trace", trace, "whether every iteration is kept in solution.trace"):
        raise ArgumentError("trace", trace, "False with lanes=True")
    return lanes, nearest


def check_lanes(options: SearchOptions) -> None:
    """Raise ArgumentError unless several starts can be tried side by side."""
    if not options.restarts:
        raise ArgumentError("lanes", True, "False; True with restarts, such as restarts=100")
    if options.best_of > 1:
        raise ArgumentError("best_of", options.best_of, "1 with lanes=True")
    if options.jump_limit < math.inf:
        raise ArgumentError("jump_limit", options.jump_limit, "None with lanes=True")


def read_executor(executor: object) -> Executor | None:
    """An executor or None. Raises ArgumentError for anything else."""
    from concurrent.futures import Executor

    if executor is None or isinstance(executor, Executor):
        return executor
    raise ArgumentError("executor", executor, "a concurrent.futures.Executor, or None")
