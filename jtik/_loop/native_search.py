"""The native search: attempts and restarts of a solve in one call of C, for a step in generated C.

Its results are bitwise equal to those of `jtik._loop.search`. Where an attempt stalls at a configuration that may be
singular, or no attempt reaches the target, it stops without a result, and the search starts again in Python.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from jtik._loop.runner import Runner
from jtik._step.inputs import SETTING, Inputs
from jtik._step.stopping import OUTCOME, Code
from jtik._step.vector_layout import VectorLayout
from jtik.symbolic.compile import Library
from jtik.types import Array

_SOURCE = r"""
#include <string.h>
#include <time.h>

/* One search: attempts until one reaches the target. Returns its code, or -1: the search in Python begins again. */
CASADI_SYMBOL_EXPORT long long JTIK_NAME_search(void** at, const double* starts, long long restarts, long long limit,
                                                double patience) {
  const double** arg = (const double**)at[0];
  double** res = (double**)at[1];
  long long* iw = (long long*)at[2];
  double* w = (double*)at[3];
  double* q[2] = {(double*)at[4], (double*)at[5]};
  double* state[2] = {(double*)at[6], (double*)at[7]};
  double* outcome = (double*)at[8];
  const double* first = (const double*)at[9];
  double* settings = (double*)at[10];
  long long* tally = (long long*)at[11]; /* iterations, attempts before this one, which memory holds q */
  const double* q0 = (const double*)at[12];
  const size_t nq = ((size_t)at[13]) * sizeof(double), ns = ((size_t)at[14]) * sizeof(double);
  tally[0] = 0;
  for (long long j = 0; j < (long long)at[13]; ++j) {
    if (!(q0[j] - q0[j] == 0)) return -1; /* not finite: the search in Python finds the argument */
  }
  for (long long number = 0; number <= restarts; ++number) {
    long long k = 0, here = 0, code = 0;
    memcpy(q[0], number ? starts + (number - 1) * (long long)at[13] : q0, nq);
    memcpy(state[0], first, ns);
    if (restarts) state[0][JTIK_PATIENCE] = patience;
    while (k < limit && code == 0) {
      arg[0] = q[here];
      arg[JTIK_STATE] = state[here];
      res[0] = q[1 - here];
      res[1] = state[1 - here];
      res[2] = outcome;
      JTIK_NAME(arg, res, iw, w, 0);
      here = 1 - here;
      ++k;
      code = (long long)outcome[JTIK_CODE];
    }
    if (code == JTIK_STALLED && (k == 1 || !restarts)) return -1;
    if (code != 0 && !outcome[JTIK_TRIED]) --k; /* the call stopped before it tried a step: not an iteration */
    tally[0] += k;
    tally[1] = number;
    tally[2] = here;
    if (!restarts || code == JTIK_DONE ||
        (k && outcome[JTIK_POSITION_ERROR] <= settings[JTIK_POSITION_TOLERANCE] &&
         outcome[JTIK_ORIENTATION_ERROR] <= settings[JTIK_ORIENTATION_TOLERANCE])) {
      return code;
    }
  }
  return -1;
}

/* The same for a table of targets, one after the other, each from its row of starts (stride 0: the same for all). */
CASADI_SYMBOL_EXPORT void JTIK_NAME_batch(void** at, const double* starts, long long restarts, long long limit,
                                          double patience, void** table) {
  const double* targets = (const double*)table[0];
  const double* from = (const double*)table[1];
  double* ends = (double*)table[2];
  double* errors = (double*)table[3];
  double* seconds = (double*)table[4];
  long long* tallies = (long long*)table[5]; /* code, iterations, restarts */
  const size_t count = (size_t)table[6], size = (size_t)table[7], stride = (size_t)table[8], nq = (size_t)at[13];
  double* target = (double*)((const double**)at[0])[JTIK_TARGET];
  double* outcome = (double*)at[8];
  long long* tally = (long long*)at[11];
  struct timespec begin, end;
  for (size_t i = 0; i < count; ++i) {
    clock_gettime(CLOCK_MONOTONIC, &begin);
    memcpy(target, targets + i * size, size * sizeof(double));
    memcpy((double*)at[12], from + i * stride, nq * sizeof(double));
    tallies[3 * i] = JTIK_NAME_search(at, starts, restarts, limit, patience);
    tallies[3 * i + 1] = tally[0];
    tallies[3 * i + 2] = tally[1];
    memcpy(ends + i * nq, (double*)at[4 + tally[2]], nq * sizeof(double));
    errors[2 * i] = outcome[JTIK_POSITION_ERROR];
    errors[2 * i + 1] = outcome[JTIK_ORIENTATION_ERROR];
    clock_gettime(CLOCK_MONOTONIC, &end);
    seconds[i] = (double)(end.tv_sec - begin.tv_sec) + 1e-9 * (double)(end.tv_nsec - begin.tv_nsec);
  }
}
"""


def source(state: VectorLayout) -> str:
    """The C code for a step whose state has this layout; every index in it comes from the named structures."""
    first = 1  # q is argument 0
    constants = {
        "STALLED": Code.STALLED,
        "DONE": Code.DONE,
        "PATIENCE": state.slices["patience"].start,
        "STATE": first + len(Inputs._fields),
        "TARGET": first + Inputs._fields.index("target"),
        "POSITION_TOLERANCE": SETTING.position_tolerance,
        "ORIENTATION_TOLERANCE": SETTING.orientation_tolerance,
        **{name.upper(): index for name, index in OUTCOME._asdict().items()},
    }
    defined = "\n".join(f"#define JTIK_{name} {int(value)}" for name, value in constants.items())
    return f"\n{defined}\n{_SOURCE}"


class NativeSearch:
    """The search in C on the memory of a runner, whose step is in generated C.

    Attributes:
        runner: the runner.
        q0: where a search begins, (nq,).
        tally: iterations, restarts used, and which memory of the runner holds q, after a search.
        run_prepared: the search that `prepare` has described, without arguments.
    """

    def __init__(self, library: Library, runner: Runner, inputs: Inputs[Array]) -> None:
        self.runner = runner
        self.q0 = np.zeros(len(runner.q[0]))
        self.tally = np.zeros(3, dtype=np.int64)
        function = library.function
        arguments = np.zeros(function.sz_arg(), dtype=np.uintp)
        results = np.zeros(function.sz_res(), dtype=np.uintp)
        integers = np.zeros(max(function.sz_iw(), 1), dtype=np.int64)
        reals = np.zeros(max(function.sz_w(), 1))
        arguments[1 : 1 + len(inputs)] = [array.ctypes.data if array.size else 0 for array in inputs]
        parts = [arguments, results, integers, reals, *runner.q, *runner.state, runner.outcome, runner.first_state]
        parts += [inputs.settings, self.tally, self.q0]
        sizes = [len(runner.q[0]), len(runner.first_state)]
        self._context = np.array([*[part.ctypes.data for part in parts], *sizes], dtype=np.uintp)
        self._kept = (parts, inputs)
        self._call = getattr(ctypes.CDLL(library.path), f"{library.name}_search")
        self._call.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_longlong, ctypes.c_longlong, ctypes.c_double]
        self._call.restype = ctypes.c_longlong
        self._address = self._context.ctypes.data
        self._starts: Array | None = None
        self.run_prepared: Callable[[], int] = partial(self._call, self._address, None, 0, 0, math.inf)
        self._batch = getattr(ctypes.CDLL(library.path), f"{library.name}_batch")
        self._batch.argtypes = [*self._call.argtypes, ctypes.c_void_p]
        self._batch.restype = None

    def prepare(self, starts: Array | None, restarts: int, limit: int, patience: float) -> None:
        """Set the options of ``run_prepared()``, which searches from the content of `q0` and returns as `find` does.

        Args:
            starts: the restart configurations, (restarts, nq); None without restarts.
            restarts: how many there are.
            limit: most calls of an attempt.
            patience: calls without progress after which an attempt that a restart can replace ends.
        """
        address = None if starts is None else starts.ctypes.data
        self._starts = starts  # kept alive
        self.run_prepared = partial(self._call, self._address, address, restarts, limit, patience)

    def find(self, q0: Array, starts: int | None, restarts: int, limit: int, patience: float) -> int:
        """Search from ``q0``.

        Args:
            q0: where to begin, (nq,).
            starts: address of the restart configurations, one after the other; None without restarts.
            restarts: how many there are.
            limit: most calls of an attempt.
            patience: calls without progress after which an attempt that a restart can replace ends.

        Returns:
            The last code, or -1 where the search in Python has to begin again.
        """
        self.q0[:] = q0
        code = int(self._call(self._address, starts, restarts, limit, patience))
        self.runner.at = int(self.tally[2])
        return code

    def batch(
        self, targets: Array, q0: Array, starts: int | None, restarts: int, limit: int, patience: float
    ) -> NativeBatch:
        """Search for each row of ``targets`` (k, size), from ``q0``: (1, nq) for all, or (k, nq)."""
        count = len(targets)
        found = NativeBatch(
            q=np.zeros((count, len(self.q0))),
            errors=np.zeros((count, 2)),
            seconds=np.zeros(count),
            tallies=np.zeros((count, 3), dtype=np.int64),
        )
        arrays = [np.ascontiguousarray(targets), np.ascontiguousarray(q0), *found]
        sizes = [count, targets.shape[1], len(self.q0) if len(q0) > 1 else 0]
        table = np.array([*[array.ctypes.data for array in arrays], *sizes], dtype=np.uintp)
        self._batch(self._address, starts, restarts, limit, patience, table.ctypes.data)
        return found


class NativeBatch(NamedTuple):
    """Where the searches for k targets ended.

    Attributes:
        q: configurations, (k, nq).
        errors: norms of position [m] and orientation [rad] rows, (k, 2).
        seconds: wall time of each, (k,) [s].
        tallies: code, iterations and restarts of each, (k, 3).
    """

    q: Array
    errors: Array
    seconds: Array
    tallies: NDArray[np.int64]
