"""The C code of a solve in one call: it reads what is given, runs a search in C, and makes the `Solution`."""

from __future__ import annotations

from jtik._loop.native import python_source
from jtik._loop.native.search_source import defined
from jtik.symbolic.compile import Beside
from jtik.task import TaskStack

ATTRIBUTES = ("q", "iterations", "restarts", "seconds", "inspect", "converged", "status", "escapes")
"""The attributes of a Solution that a search in C makes; the others are those of the class."""

EQUAL = 2
"""Python's Py_EQ."""

MEMORY = {
    "context": "void**",
    "order": "long long*",
    "patience": "double*",
    "table": "void**",
    "q0": "double*",
    "home": "double*",
    "target": "double*",
    "numbers": "double*",
    "returned": "long long*",
    "elapsed": "double*",
    "known": "char**",
    "attributes": "char**",
    "options": "long long",
    "number_count": "long long",
    "exclusive": "char*",
    "otherwise": "char*",
    "go_on": "char*",
    "report": "char*",
    "array_type": "char*",
    "float64": "char*",
    "float_type": "char*",
    "integer_type": "char*",
    "text_type": "char*",
    "none": "char*",
    "no": "char*",
    "yes": "char*",
    "zero": "char*",
    "converged": "char*",
    "solution_type": "char*",
    **{name: f"JTIK_NAME_to_{name}" for name in ("call", "pass_on", "number", "integer", "allocate", "pack", "bytes")},
    **{name: f"JTIK_NAME_to_{name}" for name in ("content", "bind", "set", "compare", "hold", "release", "leave")},
    "enter": "JTIK_NAME_to_enter",
    "new_array": "JTIK_NAME_to_new_array",
}
"""What it reads and writes, in this order, and the C type of each.

- ``context`` to ``table``: the search that is prepared, see `jtik._loop.native.search.PreparedSearch`.
- ``q0``, ``target``: where a search begins, and the numbers of its target.
- ``home``: where it begins for None.
- ``numbers``, ``number_count``: all inputs of the search, which a report needs.
- ``returned``, ``elapsed``: what a search has returned that did not converge, and the time since the call [s].
- ``known``, ``options``: the options for which the search is prepared, and how many there are.
- ``attributes``: the names of `ATTRIBUTES`.
- ``exclusive``: the guard of the solver.
- ``otherwise``: what is called with the same arguments where something is not usual; ``go_on`` after a search that did
  not converge.
- ``report``: makes the report of a Solution, from bytes of q and the inputs, and the target as it was given.
- ``array_type`` to ``solution_type``: objects; ``converged`` is the status.
- ``call`` to ``enter``: functions of Python's C interface; ``new_array``: one of NumPy's.
"""

_SOURCE = r"""
typedef struct {
JTIK_MEMORY
} JTIK_NAME_solver;

/* Where a search has ended. */
typedef struct {
  const double* q;
  long long iterations, restarts;
} JTIK_NAME_end;

JTIK_RUN

/* Whether the options are those for which the search is prepared, of the same types. */
static int JTIK_NAME_known(const JTIK_NAME_solver* at, char* const* options) {
  for (long long i = 0; i < at->options; ++i) {
    char *given = options[i], *known = at->known[i];
    if (given == known) continue;
    if (!known || JTIK_NAME_type(given) != JTIK_NAME_type(known)) return 0;
    if (JTIK_NAME_type(given) == at->float_type) {
      if (*(double*)(given + JTIK_HEAD) != *(double*)(known + JTIK_HEAD)) return 0;
    } else if (JTIK_NAME_type(given) != at->integer_type && JTIK_NAME_type(given) != at->text_type) {
      return 0;
    } else if (at->compare(given, known, JTIK_EQUAL) != 1) {
      return 0;
    }
  }
  return 1;
}

/* Write the target and q0, which need not be finite; 0 where one is left to Python. */
static int JTIK_NAME_written(const JTIK_NAME_solver* at, const char* target, const char* q0) {
  const JTIK_NAME_array* goal = JTIK_NAME_doubles(target, at->array_type, at->float64);
  if (!goal || !JTIK_NAME_aimed(goal, at->target)) return 0;
  if (q0 == at->none) {
    memcpy(at->q0, at->home, JTIK_NQ * sizeof(double));
    return 1;
  }
  const JTIK_NAME_array* start = JTIK_NAME_doubles(q0, at->array_type, at->float64);
  return start && JTIK_NAME_copied(start, JTIK_NQ, at->q0);
}

/* What makes the report of q for the inputs as they are; 0 with an error of Python's where there is no memory. */
static char* JTIK_NAME_inspect(const JTIK_NAME_solver* at, const double* q, char* target) {
  const size_t own = JTIK_NQ * sizeof(double), all = (size_t)at->number_count * sizeof(double);
  char *numbers = at->bytes(0, (ptrdiff_t)(own + all)), *given = 0, *inspect = 0;
  if (!numbers) return 0;
  memcpy(at->content(numbers), q, own);
  memcpy(at->content(numbers) + own, at->numbers, all);
  given = at->pack(2, numbers, target);
  at->release(numbers);
  if (!given) return 0;
  inspect = at->bind(at->report, given);
  at->release(given);
  return inspect;
}

/* The Solution of a search that has converged; 0 with an error of Python's where there is no memory. */
static char* JTIK_NAME_solution(const JTIK_NAME_solver* at, const JTIK_NAME_end* end, double seconds, char* target) {
  enum { MADE = 5, ALL = 8 };
  char* q = JTIK_NAME_new(at->new_array, at->array_type, at->float64, at->hold);
  if (q) memcpy(JTIK_NAME_fields(q)->data, end->q, JTIK_NQ * sizeof(double));
  char* of[ALL] = {q, at->integer(end->iterations), at->integer(end->restarts), at->number(seconds),
                   JTIK_NAME_inspect(at, end->q, target), at->yes, at->converged, at->zero};
  char* made = at->allocate(at->solution_type, 0);
  int complete = made != 0;
  for (int i = 0; i < ALL; ++i) complete = complete && of[i] && !at->set(made, at->attributes[i], of[i]);
  for (int i = 0; i < MADE; ++i) {
    if (of[i]) at->release(of[i]);
  }
  if (made && !complete) at->release(made);
  return complete ? made : 0;
}

static void JTIK_NAME_mark(const JTIK_NAME_solver* at, char* busy) {
  char **slot = (char**)(at->exclusive + JTIK_HEAD), *before = *slot;
  at->hold(busy);
  *slot = busy;
  at->release(before);
}

/* Call with the same arguments; what is called stays alive where it replaces itself meanwhile. */
static char* JTIK_NAME_passed_on(const JTIK_NAME_solver* at, char* to, char* const* given, ptrdiff_t count) {
  at->hold(to);
  char* made = at->pass_on(to, given, (size_t)count, 0);
  at->release(to);
  return made;
}

/* solve(target, q0, *options), as "otherwise" does it. The memory is the data of an array, as the function's self. The
   guard is held until the call ends, also while "go_on" runs. */
static char* JTIK_NAME_solve(char* self, char* const* given, ptrdiff_t count) {
  const JTIK_NAME_solver* at = (const JTIK_NAME_solver*)JTIK_NAME_fields(self)->data;
  const int usual = count == 2 + at->options && JTIK_NAME_known(at, given + 2);
  const double begin = usual ? JTIK_NAME_seconds() : 0;
  if (!usual || *(char**)(at->exclusive + JTIK_HEAD) != at->no || !JTIK_NAME_written(at, given[0], given[1])) {
    return JTIK_NAME_passed_on(at, at->otherwise, given, count);
  }
  JTIK_NAME_end end;
  char* made;
  JTIK_NAME_mark(at, at->yes);
  void* thread = at->leave(); /* other threads run meanwhile */
  const long long returned = JTIK_NAME_run(at, &end);
  at->enter(thread);
  if (returned == JTIK_DONE) {
    made = JTIK_NAME_solution(at, &end, JTIK_NAME_seconds() - begin, given[0]);
  } else {
    at->returned[0] = returned;
    at->elapsed[0] = JTIK_NAME_seconds() - begin;
    made = JTIK_NAME_passed_on(at, at->go_on, given, count);
  }
  JTIK_NAME_mark(at, at->no);
  return made;
}

CASADI_SYMBOL_EXPORT JTIK_NAME_method JTIK_NAME_solves[1] = {{"solve", JTIK_NAME_solve, JTIK_FASTCALL, 0}};
"""


def beside(tasks: TaskStack, run: str) -> Beside:
    """The same with what reads Python's objects, for a library without a native step.

    Args:
        tasks: the tasks.
        run: as in `source`.
    """
    reader = python_source.matrix_reader(tasks, "JTIK_NAME")
    code = defined(python_source.constants(tasks)) + python_source.SOURCE + source(run)
    return Beside(code, () if reader is None else (reader,))


def source(run: str) -> str:
    """The C code, which follows that of a search and of what reads Python's objects.

    Args:
        run: the function JTIK_NAME_run, which runs the search that is prepared.
    """
    code = _SOURCE.replace("JTIK_MEMORY", python_source.members(MEMORY)).replace("JTIK_RUN", run)
    return defined({"EQUAL": EQUAL}) + code
