"""The C code of the native step; every index in it comes from the named structures."""

from __future__ import annotations

from jtik._loop.native import python_source
from jtik._loop.native.search_source import defined, indices
from jtik._step.fused_step import FusedStep
from jtik._step.solve_progress import UNKNOWN
from jtik.qp.fast_path import NOT_WRITTEN
from jtik.symbolic import Function
from jtik.symbolic.compile import Beside
from jtik.task import TaskStack

UNREAD, USUAL, ENDED, AGAIN = 0, 1, 2, 3
"""What a step leaves to Python: all, as q or the target is to be read there; nothing; what follows an unusual end; to
repeat the call."""

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
    "new_tuple": "char*",
    "step_type": "char*",
    "call": "JTIK_NAME_to_call",
    "number": "JTIK_NAME_to_number",
    "allocate": "JTIK_NAME_to_allocate",
    "fill": "JTIK_NAME_to_fill",
    "pack": "JTIK_NAME_to_pack",
    "hold": "JTIK_NAME_to_hold",
    "release": "JTIK_NAME_to_release",
    "new_array": "JTIK_NAME_to_new_array",
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
- ``array_type`` to ``step_type``: objects; ``no`` and ``yes`` are False and True.
- ``call`` to ``release``: functions of Python's C interface; ``new_array``: one of NumPy's.
"""

_SOURCE = r"""
typedef struct {
JTIK_MEMORY
} JTIK_NAME_memory;

/* One step from q to the target. It begins in the first memory of q and state, and a usual one leaves the state there.
   Returns what it leaves to Python. */
static int JTIK_NAME_stepped(const JTIK_NAME_memory* at, const char* q, const char* target) {
  const double** arg = at->arguments;
  double** res = at->results;
  const JTIK_NAME_array* from = JTIK_NAME_doubles(q, at->array_type, at->float64);
  const JTIK_NAME_array* goal = JTIK_NAME_doubles(target, at->array_type, at->float64);
  if (!from || !goal) return JTIK_UNREAD;
  if (goal->data != (char*)at->target && !JTIK_NAME_aimed(goal, at->target)) return JTIK_UNREAD;
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
  char* q = JTIK_NAME_new(at->new_array, at->array_type, at->float64, at->hold);
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
    reader, box = python_source.matrix_reader(tasks), python_source.named(box, "jtik_step_box")
    starts = {name: where.start for name, where in fused.state.slices.items()}
    constants = {
        **indices(fused.state),
        **python_source.constants(tasks),
        **python_source.work_sizes("BOX", box),
        "TIMED": int(box is not None),
        "STATE_SIZE": fused.state.size,
        "MOMENTUM": starts.get("momentum", -1),
        "VIOLATION": starts.get("violation", -1),
        "UNKNOWN": UNKNOWN,
        "NOT_WRITTEN": int(NOT_WRITTEN),
        "USUAL": USUAL,
        "ENDED": ENDED,
        "AGAIN": AGAIN,
        "UNREAD": UNREAD,
    }
    source = _SOURCE.replace("JTIK_MEMORY", python_source.members(MEMORY))
    functions = tuple(each for each in (reader, box) if each is not None)
    return Beside(defined(constants) + python_source.SOURCE + source, functions)
