"""The C code of the native step; every index in it comes from the named structures."""

from __future__ import annotations

from jtik._loop.native_source import defined, indices
from jtik._step.fused_step import FusedStep
from jtik._step.solve_progress import UNKNOWN
from jtik.qp.fast_path import NOT_WRITTEN
from jtik.symbolic import Function
from jtik.symbolic import function as function_of
from jtik.symbolic.compile import Beside

ACCEPTED, DONE = 1, 2
"""What the native step returns for a usual end, added up; see `USUAL`."""

USUAL = ((False, False), (True, False), (False, True), (True, True))
"""Whether the step was accepted and whether nothing is left to do, by what the native step returns."""

ENDED, AGAIN, NO_POSE = -1, -2, -3
"""Otherwise: a call has ended in another way; it is to be repeated in Python; the matrix is none of a pose."""

MEMORY = {
    "arguments": "const double**",
    "results": "double**",
    "integers": "long long*",
    "reals": "double*",
    "q": "double*",
    "after": "double*",
    "state": "double*",
    "state_after": "double*",
    "outcome": "double*",
    "errors": "double*",
    "end": "double*",
    "target": "double*",
    "began": "double*",
    "last": "double*",
    "clock": "double*",
    "lower": "double*",
    "upper": "double*",
    "matrix": "long long",
    "rests": "long long",
    "remembers": "long long",
    "ahead": "long long",
}
"""What the native step reads and writes besides its arguments, in this order, and the C type of each.

- ``errors``, ``end``: errors and configuration after a usual step, in memory of their own.
- ``began`` to ``clock``: those of a `StepBox`; ``lower``, ``upper``: where it writes the box.
- ``matrix``: whether a target is a matrix (4, 4), row by row, not numbers.
- ``rests``: whether what ends done is left to Python, which tests whether the criterion is minimal there.
- ``remembers``, ``ahead``: those of the box.
"""

_SOURCE = r"""
#include <string.h>

typedef struct {
JTIK_MEMORY
} JTIK_NAME_memory;

/* One step from q to the target; without one, to that in memory. It begins in the first memory of q and state, and a
   usual one ends with the state there. */
CASADI_SYMBOL_EXPORT long long JTIK_NAME_step(const JTIK_NAME_memory* at, const char* q, const char* target) {
  const double** arg = at->arguments;
  double** res = at->results;
#if JTIK_READS
  if (target && at->matrix) {
    double T[16], read[JTIK_TARGET_SIZE], valid[1], w[JTIK_READER_W];
    const double* reader_arg[JTIK_READER_ARG] = {T};
    double* reader_res[JTIK_READER_RES] = {read, valid};
    long long iw[JTIK_READER_IW];
    memcpy(T, target, sizeof T);
    if (JTIK_NAME_matrix(reader_arg, reader_res, iw, w, 0) || !valid[0]) return JTIK_NO_POSE;
    memcpy(at->target, read, sizeof read);
  }
#endif
  if (target && !at->matrix) memcpy(at->target, target, JTIK_TARGET_SIZE * sizeof(double));
  memcpy(at->q, q, JTIK_NQ * sizeof(double));
#if JTIK_TIMED
  {
    double w[JTIK_BOX_W];
    const double* box_arg[JTIK_BOX_ARG] = {at->began, at->last, at->clock};
    double* box_res[JTIK_BOX_RES] = {at->lower, at->upper};
    long long iw[JTIK_BOX_IW];
    memcpy(at->began, q, JTIK_NQ * sizeof(double));
    if (JTIK_NAME_box(box_arg, box_res, iw, w, 0)) return JTIK_NO_POSE;
  }
#if JTIK_MOMENTUM >= 0
  if (at->ahead) { /* where the last motion leads, within the box */
    const double share = at->clock[2] * at->clock[0] / at->clock[1];
    for (int i = 0; i < JTIK_NQ; ++i) {
      double start = at->q[i] + at->last[i] * share;
      if (start < at->lower[i]) start = at->lower[i];
      if (start > at->upper[i]) start = at->upper[i];
      at->q[i] = start;
      at->state[JTIK_MOMENTUM + i] = start - at->began[i];
    }
  }
#endif
#endif
#if JTIK_VIOLATION >= 0
  at->state[JTIK_VIOLATION] = JTIK_UNKNOWN; /* obstacles, or the robot itself, may have moved between the calls */
#endif
  arg[0] = at->q;
  arg[JTIK_STATE] = at->state;
  res[0] = at->after;
  res[1] = at->state_after;
  res[2] = at->outcome;
  at->outcome[JTIK_CODE] = JTIK_NOT_WRITTEN;
  if (JTIK_NAME(arg, res, at->integers, at->reals, 0)) return JTIK_AGAIN;
  const int code = (int)at->outcome[JTIK_CODE], done = code == JTIK_DONE, accepted = at->outcome[JTIK_ACCEPTED] == 1;
  if (code == JTIK_UNSOLVED || code == JTIK_NOT_WRITTEN) return JTIK_AGAIN;
  if ((code != JTIK_CONTINUE && !done) || (done && at->rests)) return JTIK_ENDED;
  if (JTIK_TIMED && !accepted && !done) return JTIK_ENDED; /* the joints slow down */
  if (at->outcome[JTIK_TRIED]) memcpy(at->state, at->state_after, JTIK_STATE_SIZE * sizeof(double));
#if JTIK_TIMED
  if (at->remembers) {
    for (int i = 0; i < JTIK_NQ; ++i) at->last[i] = at->after[i] - at->began[i];
    at->clock[1] = at->clock[0];
  }
#endif
  at->errors[0] = at->outcome[JTIK_POSITION_ERROR];
  at->errors[1] = at->outcome[JTIK_ORIENTATION_ERROR];
  memcpy(at->end, at->after, JTIK_NQ * sizeof(double));
  return accepted * JTIK_WAS_ACCEPTED + done * JTIK_WAS_DONE;
}
"""


def beside(fused: FusedStep, nq: int, target_size: int, reader: Function | None, box: Function | None) -> Beside:
    """The native step, compiled with the fused step that it calls.

    Args:
        fused: the fused step.
        nq: number of entries of q.
        target_size: number of numbers of a target.
        reader: what reads a matrix as a target; None where there is none.
        box: gives the box of a step with a duration; None without one.
    """
    reader, box = _named(reader, "matrix"), _named(box, "box")
    starts = {name: where.start for name, where in fused.state.slices.items()}
    constants = {
        **indices(fused.state),
        **_work("READER", reader),
        **_work("BOX", box),
        "READS": int(reader is not None),
        "TIMED": int(box is not None),
        "NQ": nq,
        "TARGET_SIZE": target_size,
        "STATE_SIZE": fused.state.size,
        "MOMENTUM": starts.get("momentum", -1),
        "VIOLATION": starts.get("violation", -1),
        "UNKNOWN": UNKNOWN,
        "NOT_WRITTEN": int(NOT_WRITTEN),
        "WAS_ACCEPTED": ACCEPTED,
        "WAS_DONE": DONE,
        "ENDED": ENDED,
        "AGAIN": AGAIN,
        "NO_POSE": NO_POSE,
    }
    members = "\n".join(f"  {kind} {name};" for name, kind in MEMORY.items())
    functions = tuple(each for each in (reader, box) if each is not None)
    return Beside(defined(constants) + _SOURCE.replace("JTIK_MEMORY", members), functions)


def _named(function: Function | None, name: str) -> Function | None:
    """The same function with this name beside that of a fused step."""
    if function is None:
        return None
    symbols = function.sx_in() if function.is_a("SXFunction") else function.mx_in()
    return function_of(f"jtik_step_{name}", symbols, function.call(symbols))


def _work(prefix: str, function: Function | None) -> dict[str, int]:
    """Sizes of the memory that a call of a function works in."""
    if function is None:
        return {}
    sizes = {"ARG": function.sz_arg(), "RES": function.sz_res(), "IW": function.sz_iw(), "W": function.sz_w()}
    return {f"{prefix}_{name}": max(size, 1) for name, size in sizes.items()}
