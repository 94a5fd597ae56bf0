"""The C code of the search in lanes: several targets of a batch side by side, one in each lane of a vector step.

The attempts in lanes are compiled with it.
"""

from __future__ import annotations

from jtik._loop.lanes import attempts_source, start_bank_source
from jtik._loop.native.search_source import TURNED, macros
from jtik._step.inputs import Inputs
from jtik._step.stopping import StepOutcome
from jtik._step.vector_layout import VectorLayout
from jtik.symbolic import Function
from jtik.symbolic.lane_maths import Level, lane_maths
from jtik.symbolic.lane_source import lane_source

_INCLUDED = """
#include <time.h>
"""

_SOURCE = r"""
/* What a search that is in a lane has done; row: of its target, -1 where there is none; latest: start of the bank. */
typedef struct { long long row, number, iterations; double since; JTIK_NAME_start latest; } lane;

/* The start of an attempt in lane i. */
static JTIK_CPU void JTIK_NAME_begin(double* q, double* state, const double* start, const double* initial,
                                     double patience, int i) {
  for (int j = 0; j < JTIK_NQ; ++j) q[j * JTIK_LANES + i] = start[j];
  for (int j = 0; j < JTIK_NS; ++j) state[j * JTIK_LANES + i] = initial[j];
  if (patience < INFINITY) state[JTIK_PATIENCE * JTIK_LANES + i] = patience;
}

/* Searches for a table of targets, in the order of the table, as JTIK_NAME_batch of the native search has them. A lane
   whose search has ended takes the next target. Returns how many are done when the time is over. */
JTIK_CPU long long JTIK_NAME_lanes(void** at, const double* starts, long long first, long long last, long long limit,
                                   double patience, void** table) {
  const double* targets = (const double*)table[0];
  const double* from = (const double*)table[1];
  double* ends = (double*)table[2];
  double* errors = (double*)table[3];
  double* seconds = (double*)table[4];
  long long* tallies = (long long*)table[5]; /* code, iterations, restarts */
  const long long count = (long long)table[6], stride = (long long)table[8];
  double* work = (double*)table[9]; /* aligned as vectors are */
  const V* bank = (const V*)table[10];
  const long long size = (long long)table[11];
  const double* const* shared = (const double* const*)at[0];
  const double* initial = (const double*)at[9];
  const double* settings = (const double*)at[10];
  double* q[2] = {work, work + JTIK_NQ * JTIK_LANES};
  double* state[2] = {q[1] + JTIK_NQ * JTIK_LANES, q[1] + (JTIK_NQ + JTIK_NS) * JTIK_LANES};
  double* target = state[1] + JTIK_NS * JTIK_LANES;
  double* outcome = target + JTIK_NT * JTIK_LANES;
  V* of_starts = (V*)work + JTIK_WORK; /* distances, for each lane */
  const int several = starts != 0;
  double now = JTIK_NAME_seconds();
  const double end = now + JTIK_BUDGET;
  lane lanes[JTIK_LANES];
  long long next = 0, active = 0, steps = 0;
  int here = 0, open = 1;
  M calls = {0}; /* of each attempt */
#define OF(name) outcome[JTIK_##name * JTIK_LANES + i]
  for (int i = 0; i < JTIK_LANES; ++i) lanes[i].row = -1;
  memset(work, 0, JTIK_WORK * sizeof(V));
  for (int started = 0;; started = 1) {
    M over = {0};
    if (started) {
      JTIK_NAME_step(JTIK_ARGUMENTS, (V*)q[1 - here], (V*)state[1 - here], (V*)outcome);
      here = 1 - here;
      calls += 1;
      over = (((const V*)outcome)[JTIK_CODE] != 0.0) | (calls >= (int64_t)limit);
      if (++steps % JTIK_CHECKED == 0 && JTIK_NAME_seconds() > end + JTIK_BUDGET) { /* Python goes on with them */
        for (int i = 0; i < JTIK_LANES; ++i) {
          if (lanes[i].row >= 0) tallies[3 * lanes[i].row] = JTIK_LOOK;
        }
        return next;
      }
      if (!any(over)) continue;
      now = JTIK_NAME_seconds();
      open = now < end;
    }
    for (int i = 0; i < JTIK_LANES; ++i) {
      lane* own = lanes + i;
      if (started && (own->row < 0 || !over[i])) continue;
      long long returned = 0;
      int finished = 0;
      if (own->row >= 0) {
        const long long code = (long long)OF(CODE);
        long long k = calls[i];
        double* found = ends + own->row * JTIK_NQ;
        if (code == JTIK_UNSOLVED || (code == JTIK_STALLED && (k == 1 || !several)) ||
            (code == JTIK_SLOW && !several)) {
          returned = JTIK_LOOK;
          finished = 1;
        } else {
          if (code != 0 && !OF(TRIED)) --k;
          own->iterations += k;
          if (!several || code == JTIK_DONE ||
              (k && OF(POSITION_ERROR) <= settings[JTIK_POSITION_TOLERANCE] &&
               OF(ORIENTATION_ERROR) <= settings[JTIK_ORIENTATION_TOLERANCE])) {
            for (int j = 0; j < JTIK_NQ; ++j) found[j] = q[here][j * JTIK_LANES + i];
            memcpy((double*)at[12], from + own->row * stride, JTIK_NQ * sizeof(double));
            returned = JTIK_NAME_turned(at, found) ? JTIK_LOOK : code;
            finished = 1;
          } else if (own->number < last) {
            ++own->number;
            calls[i] = 0;
            if (size) {
              V* distances = of_starts + i * (size / JTIK_LANES);
              if (own->number == 1) JTIK_NAME_distances(distances, target + i, JTIK_LANES, bank, size);
              JTIK_NAME_follow(&own->latest, distances, size);
            }
            const double* start = starts + (size ? own->latest.index : own->number - first) * JTIK_NQ;
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
          seconds[own->row] = (now - own->since) / JTIK_LANES;
          own->row = -1;
          --active;
        }
      }
      while (own->row < 0 && open && next < count) {
        const double* start = from + next * stride;
        int finite = 1;
        for (int j = 0; j < JTIK_NQ; ++j) finite &= start[j] - start[j] == 0;
        if (!finite || limit == 0) { /* Python reads it */
          tallies[3 * next++] = JTIK_UNREADABLE;
          continue;
        }
        for (int j = 0; j < JTIK_NT; ++j) target[j * JTIK_LANES + i] = targets[next * JTIK_NT + j];
        JTIK_NAME_begin(q[here], state[here], start, initial, patience, i);
        *own = (lane){next++, 0, 0, now, JTIK_NO_START};
        calls[i] = 0;
        ++active;
      }
    }
    if (!active) return next;
  }
}
"""


def source(function: Function, state: VectorLayout, level: Level) -> str:
    """The C code of the search in lanes.

    Args:
        function: the fused step, which has lanes.
        state: layout of its state.
        level: the instructions that it uses.
    """
    names, first = Inputs._fields, 1  # q is argument 0, the state the last one
    target = first + names.index("target")
    shared = [first + i for i in range(len(names)) if first + i != target]
    sizes = {
        "NQ": function.numel_in(0),
        "NT": function.numel_in(target),
        "NS": function.numel_in(first + len(names)),
        "WORK": work_size(function, level) // level.lanes,
        **attempts_source.sizes(level),
    }
    lines = [f"#define JTIK_{name} {value}" for name, value in sizes.items()]
    arguments = {0: "(const V*)q[here]", target: "(const V*)target", first + len(names): "(const V*)state[here]"}
    call = [arguments.get(k, f"shared[{k}]") for k in range(first + len(names) + 1)]
    lines += [f"#define JTIK_ARGUMENTS {', '.join(call)}", ""]
    step = lane_source(function, "JTIK_NAME_step", shared)
    code = TURNED + start_bank_source.SOURCE + step + _SOURCE + attempts_source.SOURCE
    return "\n".join(lines) + macros(state) + "\n" + lane_maths(level) + _INCLUDED + code


def work_size(function: Function, level: Level) -> int:
    """How many numbers the search needs in memory for this step."""
    nq, ns, target = function.numel_out(0), function.numel_out(1), 1 + Inputs._fields.index("target")
    return int(level.lanes * (2 * nq + 2 * ns + function.numel_in(target) + len(StepOutcome._fields)))
