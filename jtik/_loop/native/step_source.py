"""The C code of the native step; every index in it comes from the named structures."""

from __future__ import annotations

from jtik._loop.native.object_layout import HEAD
from jtik._loop.native.search_source import defined, indices
from jtik._step.fused_step import FusedStep
from jtik._step.solve_progress import UNKNOWN
from jtik.qp.fast_path import NOT_WRITTEN
from jtik.symbolic import Function
from jtik.symbolic import function as function_of
from jtik.symbolic.compile import Beside
from jtik.task import TaskStack

UNREAD, USUAL, ENDED, AGAIN = 0, 1, 2, 3
"""What a step leaves to Python: all, as q or the target is to be read there; nothing; what follows an unusual end; to
repeat the call."""

FASTCALL = 0x80
"""The kind of a function that Python calls with an array of arguments, METH_FASTCALL."""

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
    "target": "double*",
    "began": "double*",
    "last": "double*",
    "clock": "double*",
    "lower": "double*",
    "upper": "double*",
    "rests": "long long",
    "fills": "long long",
    "remembers": "long long",
    "ahead": "long long",
    "resting": "long long*",
    "left": "long long*",
    "exclusive": "char*",
    "otherwise": "char*",
    "array_type": "char*",
    "float64": "char*",
    "float_type": "char*",
    "none": "char*",
    "no": "char*",
    "yes": "char*",
    "empty": "char*",
    "size": "char*",
    "new_tuple": "char*",
    "step_type": "char*",
    "call": "JTIK_NAME_to_call",
    "number": "JTIK_NAME_to_number",
    "allocate": "JTIK_NAME_to_allocate",
    "fill": "JTIK_NAME_to_fill",
    "pack": "JTIK_NAME_to_pack",
    "hold": "JTIK_NAME_to_count",
    "release": "JTIK_NAME_to_count",
}
"""What the native step reads and writes besides its arguments, in this order, and the C type of each.

- ``began`` to ``clock``: those of a `StepBox`; ``lower``, ``upper``: where it writes the box.
- ``rests``: whether what ends done is left to Python, which tests whether the criterion is minimal there.
- ``fills``: whether a tuple is filled, which takes less time than a copy of another one.
- ``remembers``, ``ahead``: those of the box.
- ``resting``: that of a `StepEscape`.
- ``left``: what is left to Python, after a step.
- ``exclusive``: the guard of the solver.
- ``otherwise``: what is called where a call is not usual.
- ``array_type`` to ``step_type``: objects; ``no`` and ``yes`` are False and True, ``size`` is nq.
- ``call`` to ``release``: functions of Python's C interface.
"""

_SOURCE = r"""
#include <stddef.h>
#include <string.h>

typedef char* (*JTIK_NAME_to_call)(char*, ...);
typedef char* (*JTIK_NAME_to_number)(double);
typedef char* (*JTIK_NAME_to_allocate)(char*, ptrdiff_t);
typedef int (*JTIK_NAME_to_fill)(char*, ptrdiff_t, char*);
typedef char* (*JTIK_NAME_to_pack)(ptrdiff_t, ...);
typedef void (*JTIK_NAME_to_count)(char*);

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

static const JTIK_NAME_array* JTIK_NAME_fields(const char* object) {
  return (const JTIK_NAME_array*)(object + JTIK_HEAD);
}

static const char* JTIK_NAME_type(const char* object) {
  return *(const char* const*)(object + JTIK_HEAD - sizeof(char*));
}

/* The array of doubles that an object is; 0 where it is something else. */
static const JTIK_NAME_array* JTIK_NAME_doubles(const JTIK_NAME_memory* at, const char* object) {
  const JTIK_NAME_array* array = JTIK_NAME_fields(object);
  return JTIK_NAME_type(object) == at->array_type && array->type == at->float64 ? array : 0;
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

/* One step from q to the target. It begins in the first memory of q and state, and a usual one leaves the state there.
   Returns what it leaves to Python. */
static int JTIK_NAME_stepped(const JTIK_NAME_memory* at, const char* q, const char* target) {
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
  at->resting[0] = 0;
  return JTIK_USUAL;
}

/* The Step of these six objects, which it holds from now on; 0 with an error of Python's where there is no memory. */
static char* JTIK_NAME_tuple(const JTIK_NAME_memory* at, char** of) {
  char* made = 0;
  if (at->fills) {
    made = at->allocate(at->step_type, 6);
    for (int i = 0; i < 6 && made; ++i) {
      at->hold(of[i]);
      at->fill(made, i, of[i]);
    }
  } else {
    char* tuple = at->pack(6, of[0], of[1], of[2], of[3], of[4], of[5]);
    if (tuple) {
      made = at->call(at->new_tuple, at->step_type, tuple, (char*)0);
      at->release(tuple);
    }
  }
  return made;
}

/* The Step of a usual end; 0 with an error of Python's where there is no memory. */
static char* JTIK_NAME_made(const JTIK_NAME_memory* at) {
  const double* outcome = at->outcome;
  char* q = at->call(at->empty, at->size, (char*)0);
  char* position = at->number(outcome[JTIK_POSITION_ERROR]);
  char* orientation = at->number(outcome[JTIK_ORIENTATION_ERROR]);
  char* accepted = outcome[JTIK_ACCEPTED] == 1 ? at->yes : at->no;
  char *done = (int)outcome[JTIK_CODE] == JTIK_DONE ? at->yes : at->no, *made = 0;
  if (q && position && orientation) {
    memcpy(JTIK_NAME_fields(q)->data, at->after, JTIK_NQ * sizeof(double));
    made = JTIK_NAME_tuple(at, (char*[]){q, position, orientation, accepted, done, at->no});
  }
  if (q) at->release(q);
  if (position) at->release(position);
  if (orientation) at->release(orientation);
  return made;
}

/* What Python calls: the memory is the data of an array, as the function's self. */
static const JTIK_NAME_memory* JTIK_NAME_own(const char* self) {
  return (const JTIK_NAME_memory*)JTIK_NAME_fields(self)->data;
}

/* update(q, target): the Step; None where something is left to Python. */
static char* JTIK_NAME_update(char* self, char* const* given, ptrdiff_t count) {
  const JTIK_NAME_memory* at = JTIK_NAME_own(self);
  const int left = JTIK_NAME_stepped(at, given[0], given[1]);
  at->left[0] = left == JTIK_USUAL ? JTIK_UNREAD : left; /* the next call need not come from C */
  if (left == JTIK_USUAL) return JTIK_NAME_made(at);
  at->hold(at->none);
  return at->none;
}

/* step(q, target, dt): the Step, by "otherwise" where something is left to Python. */
static char* JTIK_NAME_step(char* self, char* const* given, ptrdiff_t count) {
  const JTIK_NAME_memory* at = JTIK_NAME_own(self);
  char* dt = given[2];
#if JTIK_TIMED
  const int known = JTIK_NAME_type(dt) == at->float_type && *(double*)(dt + JTIK_HEAD) == at->clock[0];
#else
  const int known = dt == at->none;
#endif
  at->left[0] = JTIK_UNREAD;
  if (known && *(char**)(at->exclusive + JTIK_HEAD) == at->no) {
    at->left[0] = JTIK_NAME_stepped(at, given[0], given[1]);
    if (at->left[0] == JTIK_USUAL) return JTIK_NAME_made(at);
  }
  return at->call(at->otherwise, given[0], given[1], dt, (char*)0);
}

/* Two of Python's PyMethodDef. */
typedef struct {
  const char* name;
  char* (*call)(char*, char* const*, ptrdiff_t);
  int kind;
  const char* text;
} JTIK_NAME_method;

CASADI_SYMBOL_EXPORT JTIK_NAME_method JTIK_NAME_methods[2] = {
  {"step", JTIK_NAME_step, JTIK_FASTCALL, 0},
  {"update", JTIK_NAME_update, JTIK_FASTCALL, 0},
};
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
        "HEAD": HEAD,
        "FASTCALL": FASTCALL,
        "USUAL": USUAL,
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
