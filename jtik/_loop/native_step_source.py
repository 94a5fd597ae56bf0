"""The C code of the native step; every index in it comes from the named structures."""

from __future__ import annotations

from jtik._loop.native_source import defined, indices
from jtik._step.fused_step import FusedStep
from jtik._step.solve_progress import UNKNOWN
from jtik.qp.fast_path import NOT_WRITTEN
from jtik.symbolic import Function
from jtik.symbolic import function as function_of
from jtik.symbolic.compile import Beside
from jtik.task import TaskStack

ACCEPTED, DONE = 1, 2
"""What the native step returns for a usual end, added up; see `USUAL`."""

USUAL = ((False, False), (True, False), (False, True), (True, True))
"""Whether the step was accepted and whether nothing is left to do, by what the native step returns."""

ENDED, AGAIN, UNREAD = -1, -2, -3
"""Otherwise: a call has ended in another way; it is to be repeated in Python; q or the target is to be read there."""

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
    "target": "double*",
    "began": "double*",
    "last": "double*",
    "clock": "double*",
    "lower": "double*",
    "upper": "double*",
    "head": "long long",
    "array_type": "const char*",
    "float_type": "const char*",
    "rests": "long long",
    "remembers": "long long",
    "ahead": "long long",
}
"""What the native step reads and writes besides its arguments, in this order, and the C type of each.

- ``errors``: the errors after a usual step, in memory of their own.
- ``began`` to ``clock``: those of a `StepBox`; ``lower``, ``upper``: where it writes the box.
- ``head``, ``array_type``, ``float_type``: what `jtik._loop.array_layout` tells of arrays.
- ``rests``: whether what ends done is left to Python, which tests whether the criterion is minimal there.
- ``remembers``, ``ahead``: those of the box.
"""

_SOURCE = r"""
#include <stddef.h>
#include <string.h>

typedef struct {
JTIK_MEMORY
} JTIK_NAME_memory;

/* A NumPy array after the head of every object. */
typedef struct {
  char* data;
  int dimensions;
  const ptrdiff_t* shape;
  const ptrdiff_t* strides;
  void* base;
  const char* type;
} JTIK_NAME_array;

/* The array of doubles that an object is; 0 where it is something else. */
static const JTIK_NAME_array* JTIK_NAME_doubles(const JTIK_NAME_memory* at, const char* object) {
  const JTIK_NAME_array* array = (const JTIK_NAME_array*)(object + at->head);
  if (*(const char* const*)(object + at->head - sizeof(char*)) != at->array_type) return 0;
  return array->type == at->float_type ? array : 0;
}

/* Copy a vector of this size; 0 where the array is none. */
static int JTIK_NAME_copied(const JTIK_NAME_array* array, ptrdiff_t size, double* to) {
  if (array->dimensions != 1 || array->shape[0] != size) return 0;
  for (ptrdiff_t i = 0; i < size; ++i) memcpy(to + i, array->data + i * array->strides[0], sizeof(double));
  return 1;
}

#if JTIK_READS
/* Read a matrix (4, 4) as a target; 0 where the array is none, or is no pose. */
static int JTIK_NAME_read(const JTIK_NAME_array* array, double* to) {
  double T[16], target[JTIK_TARGET_SIZE], valid[1], w[JTIK_READER_W];
  const double* arg[JTIK_READER_ARG] = {T};
  double* res[JTIK_READER_RES] = {target, valid};
  long long iw[JTIK_READER_IW];
  if (array->dimensions != 2 || array->shape[0] != 4 || array->shape[1] != 4) return 0;
  for (ptrdiff_t i = 0; i < 16; ++i) {
    memcpy(T + i, array->data + i / 4 * array->strides[0] + i % 4 * array->strides[1], sizeof(double));
  }
  if (JTIK_NAME_matrix(arg, res, iw, w, 0) || !valid[0]) return 0;
  memcpy(to, target, sizeof target);
  return 1;
}
#endif

/* One step from q to the target, which ends in the array "to" (nq,). It begins in the first memory of q and state, and
   a usual one leaves the state there. */
CASADI_SYMBOL_EXPORT long long JTIK_NAME_step(const JTIK_NAME_memory* at, const char* q, const char* target,
                                              const char* to) {
  const double** arg = at->arguments;
  double** res = at->results;
  const JTIK_NAME_array *from = JTIK_NAME_doubles(at, q), *goal = JTIK_NAME_doubles(at, target);
  if (!from || !goal) return JTIK_UNREAD;
  int read = goal->data == (char*)at->target;
#if JTIK_READS
  read = read || JTIK_NAME_read(goal, at->target);
#endif
  if (!read && !(JTIK_IS_VECTOR && JTIK_NAME_copied(goal, JTIK_TARGET_SIZE, at->target))) return JTIK_UNREAD;
  if (!JTIK_NAME_copied(from, JTIK_NQ, at->q)) return JTIK_UNREAD;
#if JTIK_TIMED
  {
    double w[JTIK_BOX_W];
    const double* box_arg[JTIK_BOX_ARG] = {at->began, at->last, at->clock};
    double* box_res[JTIK_BOX_RES] = {at->lower, at->upper};
    long long iw[JTIK_BOX_IW];
    memcpy(at->began, at->q, JTIK_NQ * sizeof(double));
    if (JTIK_NAME_box(box_arg, box_res, iw, w, 0)) return JTIK_UNREAD;
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
  memcpy(((const JTIK_NAME_array*)(to + at->head))->data, at->after, JTIK_NQ * sizeof(double));
  return accepted * JTIK_WAS_ACCEPTED + done * JTIK_WAS_DONE;
}
"""


def beside(fused: FusedStep, tasks: TaskStack, box: Function | None) -> Beside:
    """The native step, compiled with the fused step that it calls.

    Args:
        fused: the fused step.
        tasks: its tasks.
        box: gives the box of a step with a duration; None without one.
    """
    reader, box = _named(tasks.matrix_reader, "matrix"), _named(box, "box")
    starts = {name: where.start for name, where in fused.state.slices.items()}
    constants = {
        **indices(fused.state),
        **_work("READER", reader),
        **_work("BOX", box),
        "READS": int(reader is not None),
        "IS_VECTOR": int(tasks.target_is_vector),
        "TIMED": int(box is not None),
        "NQ": tasks.robot.nq,
        "TARGET_SIZE": tasks.target_size,
        "STATE_SIZE": fused.state.size,
        "MOMENTUM": starts.get("momentum", -1),
        "VIOLATION": starts.get("violation", -1),
        "UNKNOWN": UNKNOWN,
        "NOT_WRITTEN": int(NOT_WRITTEN),
        "WAS_ACCEPTED": ACCEPTED,
        "WAS_DONE": DONE,
        "ENDED": ENDED,
        "AGAIN": AGAIN,
        "UNREAD": UNREAD,
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
