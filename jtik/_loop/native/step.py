"""The native step: one call of `InverseKinematics.step` in one call of C, for a step in generated C.

Its results are bitwise equal to those of `jtik._loop.stepping`, which goes on where a call ends in an unusual way. Its
functions are those of an extension module: calls through ctypes take longer, the more so where caches are cold.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import Any

import numpy as np

from jtik._loop.escapes.criterion import StepEscape
from jtik._loop.exclusive_use import ExclusiveUse
from jtik._loop.native import object_layout
from jtik._loop.native.step_source import MEMORY, UNREAD
from jtik._loop.runner import Runner
from jtik.constraints.step_box import StepBox
from jtik.result.step import Step
from jtik.symbolic.compile import Library

Call = Callable[[Any, Any, Any], Step]
"""(q, target, dt) -> the step."""


class Method(ctypes.Structure):
    """Python's PyMethodDef."""

    _fields_ = (
        ("name", ctypes.c_char_p),
        ("call", ctypes.c_void_p),
        ("kind", ctypes.c_int),
        ("text", ctypes.c_char_p),
    )


class Memory(np.ndarray):
    """The addresses of what C reads and writes, which keep it alive. A function of C has them as its self.

    Attributes:
        kept: what is kept alive.
    """

    kept: dict[str, object]


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
        api = ctypes.pythonapi
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
            "rests": escape.possible,
            "fills": object_layout.tuples_have_items_only(),
            "remembers": bool(box and box.remembers),
            "ahead": bool(box and box.ahead),
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
            "empty": np.empty,
            "size": len(runner.q[0]),
            "new_tuple": tuple.__new__,
            "step_type": Step,
        }
        functions = {
            "call": api.PyObject_CallFunctionObjArgs,
            "number": api.PyFloat_FromDouble,
            "allocate": api.PyType_GenericAlloc,
            "fill": api.PyTuple_SetItem,
            "pack": api.PyTuple_Pack,
            "hold": api.Py_IncRef,
            "release": api.Py_DecRef,
        }
        values = {
            **{name: array.ctypes.data for name, array in arrays.items()},
            **{name: int(flag) for name, flag in flags.items()},
            **{name: id(each) for name, each in objects.items()},
            **{name: ctypes.cast(each, ctypes.c_void_p).value for name, each in functions.items()},
        }
        self._memory = np.array([values[name] for name in MEMORY], dtype=np.uintp).view(Memory)
        self._memory.kept = {**arrays, **objects, "inputs": inputs, "library": library}
        # a call keeps the interpreter: it is short, and no controller waits for another thread after it
        methods = (Method * 2).in_dll(library.loaded, f"{library.name}_methods")
        self._step: Call
        self.update: Callable[[Any, Any], Step | None]
        self._step, self.update = (_NEW_FUNCTION(ctypes.addressof(each), self._memory, None) for each in methods)

    def before(self, otherwise: Call) -> Call:
        """``step(q, target, dt)``, which calls ``otherwise`` with the same arguments for what is left to Python."""
        self._memory.kept["otherwise"] = otherwise
        self._memory[list(MEMORY).index("otherwise")] = id(otherwise)
        return self._step

    def left(self) -> int:
        """What the last call has left to Python, which is then no longer left; UNREAD where there was none."""
        left, self._left[0] = int(self._left[0]), UNREAD
        return left


_NEW_FUNCTION = ctypes.PYFUNCTYPE(ctypes.py_object, ctypes.c_void_p, ctypes.py_object, ctypes.c_void_p)(
    ("PyCFunction_NewEx", ctypes.pythonapi)
)
"""(method, self, module) -> function."""
