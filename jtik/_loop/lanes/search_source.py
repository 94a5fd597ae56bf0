"""The C code of the search in lanes: several targets of a batch side by side, one in each lane of a vector step.

Its double-precision form continues what the form in single precision has found. The attempts in lanes are compiled with
the former.
"""

from __future__ import annotations

from jtik._loop.lanes import attempts_source, refinement_source
from jtik._loop.native import start_bank_source
from jtik._loop.native.search_source import TURNED, macros
from jtik._step.inputs import Inputs
from jtik._step.stopping import StepOutcome
from jtik._step.vector_layout import VectorLayout
from jtik.symbolic import Function
from jtik.symbolic.lanes.maths import Level, lane_maths
from jtik.symbolic.lanes.source import lane_source

COARSE = 2e-5
"""Errors with which the search in single precision ends, where the tolerances are smaller [m], [rad]."""

LARGEST = 16.0
"""Largest number of a start or target that it takes: the rounding of larger ones is not far below `COARSE`."""

LONGEST = 100_000_000
"""Instructions of a step times steps, after which a search is left to Python: some hundredths of a second."""

ENDED = 16
"""Ends of attempts after which the time is read again."""

_INCLUDED = """
#include <time.h>
"""

_BEGIN = r"""
/* The start of an attempt in lane i. */
static JTIK_CPU void JTIK_NAME_begin(R* q, R* state, const double* start, const double* initial, double patience,
                                     int i) {
  for (int j = 0; j < JTIK_NQ; ++j) q[j * JTIK_LANES + i] = start[j];
  for (int j = 0; j < JTIK_NS; ++j) state[j * JTIK_LANES + i] = initial[j];
  if (patience < INFINITY) state[JTIK_PATIENCE * JTIK_LANES + i] = patience;
}
"""

_SINGLE = r"""
/* The inputs in single precision; tolerances that are smaller than what it tells apart are that. */
static void JTIK_NAME_inputs(R* numbers, const R** inputs, const double* const* given) {
  static const int sizes[] = {JTIK_SIZES};
  for (int k = 0; k < (int)(sizeof(sizes) / sizeof(*sizes)); numbers += sizes[k++]) {
    inputs[k] = numbers;
    for (int j = 0; j < sizes[k]; ++j) numbers[j] = given[k][j];
    if (k != JTIK_SETTINGS) continue;
    if (numbers[JTIK_POSITION_TOLERANCE] < JTIK_COARSE) numbers[JTIK_POSITION_TOLERANCE] = JTIK_COARSE;
    if (numbers[JTIK_ORIENTATION_TOLERANCE] < JTIK_COARSE) numbers[JTIK_ORIENTATION_TOLERANCE] = JTIK_COARSE;
  }
}

/* Whether single precision tells numbers of this size apart. */
JTIK_INLINE int JTIK_NAME_are_usual(const double* numbers, int count) {
  int are = 1;
  for (int j = 0; j < count; ++j) are &= fabs(numbers[j]) <= JTIK_LARGEST;
  return are;
}
"""

_SOURCE = r"""
/* What a search that is in a lane has done; row: of its target, -1 where there is none; refines: its attempt began
   where the search in single precision had ended; since: number of steps before it; latest: key of its start. */
typedef struct {
  long long row, number, iterations;
  int refines;
  long long since;
  int32_t latest;
} lane;

/* Searches for a table of targets, in the order of the table, as JTIK_NAME_batch of the native search has them. A lane
   whose search has ended takes the next target. Returns how many are done when the time is over and those that had
   begun have ended.
   arrived_after, NULL without a search in single precision, is that one's result and an argument of the other: the
   steps of the attempt that has come close to the target, -1 where none has. The numbers of steps and restarts before
   that attempt, and where it has ended, are then in the table. */
JTIK_CPU long long JTIK_NAME_lanes(void** at, const JTIK_NAME_starts* starts, long long first, long long last,
                                   long long limit, double patience, void** table) {
  const double* targets = (const double*)table[0];
  const double* from = (const double*)table[1];
  double* ends = (double*)table[2];
  double* errors = (double*)table[3];
  double* seconds = (double*)table[4];
  long long* tallies = (long long*)table[5]; /* code, iterations, restarts */
  const long long count = (long long)table[6], stride = (long long)table[8];
  R* work = (R*)table[9]; /* aligned as vectors are */
  long long* arrived_after = (long long*)table[10];
  const double* const* given = (const double* const*)at[0];
  const double* initial = (const double*)at[9];
  R* q[2] = {work, work + JTIK_NQ * JTIK_LANES};
  R* state[2] = {q[1] + JTIK_NQ * JTIK_LANES, q[1] + (JTIK_NQ + JTIK_NS) * JTIK_LANES};
  R* target = state[1] + JTIK_NS * JTIK_LANES;
  R* outcome = target + JTIK_NT * JTIK_LANES;
  int32_t* of_lanes = (int32_t*)((V*)work + JTIK_WORK); /* keys of starts, for each lane */
#ifdef JTIK_SINGLE
  const R* shared[JTIK_STATE];
  JTIK_NAME_inputs((R*)(of_lanes + JTIK_BANK * JTIK_LANES), shared, given);
#else
  const R* const* shared = given;
#endif
  const R* settings = shared[JTIK_SETTINGS];
  const I longest = limit < JTIK_LONGEST ? limit : JTIK_LONGEST;
  const int several = starts != 0;
  const long long size = several ? starts->size : 0;
  double begin = JTIK_NAME_seconds(), of_step = 0; /* mean time of a step */
  const double end = begin + JTIK_BUDGET;
  lane lanes[JTIK_LANES];
  long long next = 0, active = 0, steps = 0, ended = 0;
  int here = 0, open = 1;
  M calls = {0}; /* of each attempt */
#define OF(name) outcome[JTIK_##name * JTIK_LANES + i]
#ifdef JTIK_FINISHED
  if (arrived_after) JTIK_NAME_refine(at, limit, patience, table);
  begin = JTIK_NAME_seconds();
#endif
  for (int i = 0; i < JTIK_LANES; ++i) lanes[i].row = -1;
  memset(work, 0, JTIK_WORK * sizeof(V));
  for (int started = 0;; started = 1) {
    M over = {0};
    if (started) {
      JTIK_NAME_step(JTIK_ARGUMENTS, (V*)q[1 - here], (V*)state[1 - here], (V*)outcome);
      here = 1 - here;
      calls += 1;
      ++steps;
      over = (((const V*)outcome)[JTIK_CODE] != ALL(0)) | (calls >= longest);
      if (!any(over)) continue;
      if (ended++ % JTIK_ENDED == 0) {
        const double now = JTIK_NAME_seconds();
        of_step = (now - begin) / steps;
        open = now < end;
      }
    }
    for (int i = 0; i < JTIK_LANES; ++i) {
      lane* own = lanes + i;
      if (started && (own->row < 0 || !over[i])) continue;
      long long returned = 0;
      int finished = 0;
      if (own->row >= 0) {
        const long long code = (long long)OF(CODE), k = calls[i] - (code != 0 && !OF(TRIED));
        const int arrived = !several || code == JTIK_DONE ||
                            (k && OF(POSITION_ERROR) <= settings[JTIK_POSITION_TOLERANCE] &&
                             OF(ORIENTATION_ERROR) <= settings[JTIK_ORIENTATION_TOLERANCE]);
        const int is_long = (code == 0 && calls[i] < limit) || (!arrived && own->iterations + k >= JTIK_LONGEST);
        const int unusual = is_long || code == JTIK_UNSOLVED ||
                            (code == JTIK_STALLED && (calls[i] == 1 || !several)) || (code == JTIK_SLOW && !several);
        if (own->refines && !arrived) { /* the search begins anew */
          JTIK_NAME_begin(q[here], state[here], from + own->row * stride, initial, patience, i);
          *own = (lane){own->row, 0, own->iterations + k, 0, own->since, JTIK_FIRST};
          calls[i] = 0;
        } else if (unusual) {
          returned = JTIK_LOOK;
          finished = 1;
        } else if (arrived) {
          double* found = ends + own->row * JTIK_NQ;
          for (int j = 0; j < JTIK_NQ; ++j) found[j] = q[here][j * JTIK_LANES + i];
#ifdef JTIK_SINGLE
          for (int j = 0; j < JTIK_NQ; ++j) { /* rounding may have left the limits */
            const double least = given[JTIK_LOWER][j], most = given[JTIK_UPPER][j];
            found[j] = found[j] < least ? least : found[j] > most ? most : found[j];
          }
          arrived_after[own->row] = k;
#else
          own->iterations += k;
          memcpy((double*)at[12], from + own->row * stride, JTIK_NQ * sizeof(double));
          returned = JTIK_NAME_turned(at, found) ? JTIK_LOOK : code;
#endif
          finished = 1;
        } else {
          own->iterations += k;
          if (own->number < last) {
            ++own->number;
            calls[i] = 0;
            if (size) {
              int32_t* keys = of_lanes + i * JTIK_BANK;
              if (own->number == 1) JTIK_NAME_keys(keys, starts, targets + own->row * JTIK_NT, JTIK_NT);
              own->latest = JTIK_NAME_following(keys, own->latest);
            }
            const long long row = size ? own->latest & (JTIK_BANK - 1) : own->number - first;
            const double* start = starts->configurations + row * JTIK_NQ;
            JTIK_NAME_begin(q[here], state[here], start, initial, patience, i);
          } else {
            returned = JTIK_EXHAUSTED;
            finished = 1;
          }
        }
        if (finished) {
          tallies[3 * own->row] = returned;
          tallies[3 * own->row + 1] = own->iterations;
          tallies[3 * own->row + 2] = own->number;
          errors[2 * own->row] = OF(POSITION_ERROR);
          errors[2 * own->row + 1] = OF(ORIENTATION_ERROR);
          seconds[own->row] += (steps - own->since) * of_step / JTIK_LANES;
          own->row = -1;
          --active;
        }
      }
      while (own->row < 0 && open && next < count) {
        const double* start = from + next * stride;
#ifdef JTIK_SINGLE
        arrived_after[next] = -1;
        if (!JTIK_NAME_are_usual(start, JTIK_NQ) || !JTIK_NAME_are_usual(targets + next * JTIK_NT, JTIK_NT)) {
          tallies[3 * next + 1] = 0;
          ++next;
          continue;
        }
        *own = (lane){next, 0, 0, 0, steps, JTIK_FIRST};
        calls[i] = 0;
#else
        int finite = 1;
        for (int j = 0; j < JTIK_NQ; ++j) finite &= start[j] - start[j] == 0;
        if (!finite || limit == 0) { /* Python reads it */
          tallies[3 * next++] = JTIK_UNREADABLE;
          continue;
        }
#ifdef JTIK_FINISHED
        if (arrived_after && arrived_after[next] <= JTIK_FINISHED) {
          ++next;
          continue;
        }
#endif
        const long long *tally = tallies + 3 * next, before = arrived_after ? arrived_after[next] : -1;
        const int refines = 0 <= before && before < limit;
        const long long made = !arrived_after ? 0 : refines || before < 0 ? tally[1] : tally[1] + before;
        *own = (lane){next, refines ? tally[2] : 0, made, refines, steps, JTIK_FIRST};
        calls[i] = refines ? before : 0;
        if (refines) start = ends + next * JTIK_NQ;
#endif
        for (int j = 0; j < JTIK_NT; ++j) target[j * JTIK_LANES + i] = targets[next * JTIK_NT + j];
        JTIK_NAME_begin(q[here], state[here], start, initial, patience, i);
        ++next;
        ++active;
      }
    }
    if (!active) return next;
  }
#undef OF
}
"""


def source(
    function: Function, state: VectorLayout, level: Level, *, single: bool = False, refines: bool = False
) -> str:
    """The C code of the search in lanes.

    Args:
        function: the fused step, which has lanes.
        state: layout of its state.
        level: the instructions that it uses.
        single: whether it is the search in single precision, to which no attempts belong.
        refines: whether it continues one in single precision.
    """
    names, first = Inputs._fields, 1  # q is argument 0, the state the last one
    target = first + names.index("target")
    shared = [first + i for i in range(len(names)) if first + i != target]
    sizes = {
        "NQ": function.numel_in(0),
        "NT": function.numel_in(target),
        "NS": function.numel_in(first + len(names)),
        "WORK": work_size(function, level) // level.lanes,
        "ENDED": ENDED,
        "LONGEST": max(LONGEST // function.n_instructions(), 1),
        **attempts_source.sizes(level),
    }
    if refines:
        sizes["FINISHED"] = refinement_source.FINISHED
    if single:
        inputs = [function.numel_in(k) if k in shared else 0 for k in range(first + len(names))]
        sizes |= {"SINGLE": 1, "SIZES": ", ".join(map(str, inputs)), "COARSE": COARSE, "LARGEST": LARGEST}
    lines = [f"#define JTIK_{name} {value}" for name, value in sizes.items()]
    arguments = {0: "(const V*)q[here]", target: "(const V*)target", first + len(names): "(const V*)state[here]"}
    call = [arguments.get(k, f"shared[{k}]") for k in range(first + len(names) + 1)]
    lines += [f"#define JTIK_ARGUMENTS {', '.join(call)}", ""]
    step = lane_source(function, "JTIK_NAME_step", shared)
    code = TURNED + start_bank_source.SOURCE + step + _BEGIN
    code += refinement_source.source(function, shared) if refines else ""
    code += _SINGLE + _SOURCE if single else _SOURCE + attempts_source.SOURCE
    return "\n".join(lines) + macros(state) + "\n" + lane_maths(level, single=single) + _INCLUDED + code


def work_size(function: Function, level: Level) -> int:
    """How many numbers the search needs in memory for this step, in either precision."""
    nq, ns, target = function.numel_out(0), function.numel_out(1), 1 + Inputs._fields.index("target")
    return int(level.lanes * (2 * nq + 2 * ns + function.numel_in(target) + len(StepOutcome._fields)))
