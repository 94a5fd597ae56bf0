"""The native step: one call of `InverseKinematics.step` in one call of C, for a step in generated C.

Its results are bitwise equal to those of `jtik._loop.stepping`, which goes on where a call ends in an unusual way.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from jtik._loop.escapes.criterion import StepEscape
from jtik._loop.exclusive_use import ExclusiveUse
from jtik._loop.native import object_layout
from jtik._loop.native.python_function import functions, memory_of
from jtik._loop.native.step_source import MEMORY, UNREAD
from jtik._loop.runner import Runner
from jtik.constraints.step_box import StepBox
from jtik.result.step import Step
from jtik.symbolic.compile import Library

Call = Callable[[Any, Any, Any], Step]
"""(q, target, dt) -> the step."""


class NativeStep:
    """The step in C on the memory of a runner, whose first memory of q and state it begins and ends in.

    Args:
        library: the step as a shared library.
        runner: the runner.
        box: the box of a step with a duration; None without one.
        escape: the criterion escape; what ends done is left to Python where it is possible.
        exclusive: the guard of the solver; while it is busy, all is left to Python.

    Attributes:
        target: memory of the numbers of the target; as a target it is the one that is there.
        update: ``update(q, target)``, of two arrays: the `Step`, or None where something is left to Python.
    """

    def __init__(
        self, library: Library, runner: Runner, box: StepBox | None, *, escape: StepEscape, exclusive: ExclusiveUse
    ) -> None:
        function, inputs = library.function, runner.inputs
        arguments = np.zeros(function.sz_arg(), dtype=np.uintp)
        arguments[1 : 1 + len(inputs)] = [array.ctypes.data if array.size else 0 for array in inputs]
        self.target = inputs.target
        self._left = np.zeros(1, dtype=np.int64)
        unused = np.zeros(1)
        arrays = {
            "arguments": arguments,
            "results": np.zeros(function.sz_res(), dtype=np.uintp),
            "integers": np.zeros(max(function.sz_iw(), 1), dtype=np.int64),
            "reals": np.zeros(max(function.sz_w(), 1)),
            "q": runner.q[0],
            "after": runner.q[1],
            "state": runner.state[0],
            "state_after": runner.state[1],
            "outcome": runner.outcome,
            "target": inputs.target,
            "began": box.q if box else unused,
            "last": box.last if box else unused,
            "clock": box.clock if box else unused,
            "lower": inputs.lower,
            "upper": inputs.upper,
            "resting": escape.resting,
            "left": self._left,
        }
        flags = {
            "rests": int(escape.possible),
            "fills": int(object_layout.tuples_have_items_only()),
            "remembers": int(bool(box and box.remembers)),
            "ahead": int(bool(box and box.ahead)),
        }
        objects = {
            "exclusive": exclusive,
            "otherwise": None,
            "array_type": np.ndarray,
            "float64": np.dtype(np.float64),
            "float_type": float,
            "none": None,
            "no": False,
            "yes": True,
            "new_tuple": tuple.__new__,
            "step_type": Step,
        }
        kept = {"inputs": inputs, "library": library}
        self._memory = memory_of(MEMORY, arrays=arrays, numbers=flags, objects=objects, kept=kept)
        # a call keeps the interpreter: it is short, and no controller waits for another thread after it
        self._step: Call
        self.update: Callable[[Any, Any], Step | None]
        self._step, self.update = functions(library.loaded, f"{library.name}_methods", 2, self._memory)

    def before(self, otherwise: Call) -> Call:
        """``step(q, target, dt)``, which calls ``otherwise`` with the same arguments for what is left to Python."""
        self._memory.kept["otherwise"] = otherwise
        self._memory[list(MEMORY).index("otherwise")] = id(otherwise)
        return self._step

    def left(self) -> int:
        """What the last call has left to Python, which is then no longer left; UNREAD where there was none."""
        left, self._left[0] = int(self._left[0]), UNREAD
        return left
