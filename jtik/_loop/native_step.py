"""The native step: one call of `InverseKinematics.step` in one call of C, for a step in generated C.

Its results are bitwise equal to those of `jtik._loop.stepping`, which goes on where a call ends in an unusual way.
"""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np

from jtik._loop.array_layout import HEAD
from jtik._loop.native_step_source import MEMORY
from jtik._loop.runner import Runner
from jtik.constraints.step_box import StepBox
from jtik.symbolic.compile import Library


class NativeStep:
    """The step in C on the memory of a runner, whose first memory of q and state it begins and ends in.

    Args:
        library: the step as a shared library.
        runner: the runner.
        box: the box of a step with a duration; None without one.
        rests: whether what ends done is left to Python.

    Attributes:
        call: the step: ``call(memory, id(q), id(target), id(end))``. Where q and target are arrays, it writes where it
            ends into the array ``end`` (nq,), and returns what `jtik._loop.native_step_source` describes.
        memory: address of what it works on.
        target: memory of the numbers of the target; as a target it is the one that is there.
        errors: memory of the norms of the errors after a usual step [m] and [rad].
        nq: number of entries of q.
    """

    def __init__(self, library: Library, runner: Runner, box: StepBox | None, *, rests: bool) -> None:
        function, inputs = library.function, runner.inputs
        arguments = np.zeros(function.sz_arg(), dtype=np.uintp)
        arguments[1 : 1 + len(inputs)] = [array.ctypes.data if array.size else 0 for array in inputs]
        self.nq, errors = len(runner.q[0]), np.zeros(2)
        self.errors: Any = memoryview(errors.data)
        self.target = inputs.target
        unused = np.zeros(1)
        memory: dict[str, Any] = {
            "arguments": arguments,
            "results": np.zeros(function.sz_res(), dtype=np.uintp),
            "integers": np.zeros(max(function.sz_iw(), 1), dtype=np.int64),
            "reals": np.zeros(max(function.sz_w(), 1)),
            "q": runner.q[0],
            "after": runner.q[1],
            "state": runner.state[0],
            "state_after": runner.state[1],
            "outcome": runner.outcome,
            "errors": errors,
            "target": inputs.target,
            "began": box.q if box else unused,
            "last": box.last if box else unused,
            "clock": box.clock if box else unused,
            "lower": inputs.lower,
            "upper": inputs.upper,
            "head": HEAD,
            "array_type": id(np.ndarray),
            "float_type": id(np.dtype(np.float64)),
            "rests": rests,
            "remembers": bool(box and box.remembers),
            "ahead": bool(box and box.ahead),
        }
        values = [memory[name] for name in MEMORY]
        own = [each.ctypes.data if isinstance(each, np.ndarray) else int(each) for each in values]
        table = np.array(own, dtype=np.uintp)
        self.memory = table.ctypes.data
        self._kept = table, memory, inputs, library
        # a call keeps the interpreter: it is short, and no controller waits for another thread after it
        self.call: Any = getattr(ctypes.PyDLL(library.path), f"{library.name}_step")
        self.call.argtypes = [ctypes.c_void_p] * 4
        self.call.restype = ctypes.c_longlong
