"""The C code of the attempts in lanes: one target from several starts, one attempt in each lane of a vector step."""

from __future__ import annotations

from jtik._step.inputs import Inputs
from jtik._step.stopping import StepOutcome
from jtik.symbolic import Function
from jtik.symbolic.lanes.maths import Level

TOGETHER = 4
"""Attempts at the same time. Answers depend on it, so it is the same on every processor."""

SOURCE = r"""
/* Memory of a vector step. */
typedef struct { double *q[2], *state[2], *outcome; } JTIK_NAME_memory;

/* An attempt that is in a lane; number: -1 where there is none; begun: number of rounds before it. */
typedef struct { long long number, begun; } JTIK_NAME_attempt;

/* Attempts from q0, then from the starts, some at the same time. A round is a step of each. The arrival of the first
   round that has one wins, of several in one round that with the smallest number; with nearest the attempt from q0 goes
   on, and wins where it arrives. Returns the code of its last call; or JTIK_LOOK: the search in Python begins anew; or
   JTIK_EXHAUSTED: none has arrived; or JTIK_UNREADABLE: q0 is not finite. */
JTIK_CPU long long JTIK_NAME_attempts(void** at, const JTIK_NAME_starts* starts, long long first, long long last,
                                      long long limit, double patience, void** table) {
  double* found = (double*)table[0];
  double* errors = (double*)table[1];
  long long* tally = (long long*)table[2]; /* code, iterations, restarts */
  double* target = (double*)table[3];      /* memory, aligned as vectors are */
  const long long size = starts ? starts->size : 0, nearest = (long long)table[4];
  const double* const* shared = (const double* const*)at[0];
  const double* initial = (const double*)at[9];
  const double* settings = (const double*)at[10];
  const double* q0 = (const double*)at[12];
  double* work = target + JTIK_NT * JTIK_LANES;
  JTIK_NAME_memory memory[JTIK_VECTORS];
  JTIK_NAME_attempt attempts[JTIK_PLACES];
  int32_t keys[JTIK_BANK], latest = JTIK_FIRST;
  long long next = 0, rounds = 0, iterations = 0, winner = -1, won = 0, code = 0;
  int here = 0, active = 0;
#define OF(p) memory[(p) / JTIK_LANES]
#define OUT(p, name) OF(p).outcome[JTIK_##name * JTIK_LANES + (p) % JTIK_LANES]
  for (int j = 0; j < JTIK_NQ; ++j) {
    if (q0[j] - q0[j] != 0) return tally[0] = JTIK_UNREADABLE;
  }
  if (limit == 0) return tally[0] = JTIK_LOOK;
  for (int j = 0; j < JTIK_NT; ++j) {
    for (int i = 0; i < JTIK_LANES; ++i) target[j * JTIK_LANES + i] = shared[JTIK_TARGET][j];
  }
  for (int v = 0; v < JTIK_VECTORS; ++v) {
    for (int h = 0; h < 2; ++h, work += JTIK_NQ * JTIK_LANES) memory[v].q[h] = work;
    for (int h = 0; h < 2; ++h, work += JTIK_NS * JTIK_LANES) memory[v].state[h] = work;
    memory[v].outcome = work;
    work += JTIK_NO * JTIK_LANES;
  }
  for (int p = 0; p < JTIK_PLACES; ++p) { /* also where no attempt begins: what is computed there is not read */
    JTIK_NAME_begin(OF(p).q[0], OF(p).state[0], q0, initial, patience, p % JTIK_LANES);
    attempts[p].number = -1;
  }
  for (;;) {
    for (int p = 0; p < JTIK_TOGETHER && next <= last && winner < 0; ++p) {
      if (attempts[p].number >= 0) continue;
      if (next) {
        if (size && next == 1) JTIK_NAME_keys(keys, starts, shared[JTIK_TARGET], JTIK_NT);
        if (size) latest = JTIK_NAME_following(keys, latest);
        const long long row = size ? latest & (JTIK_BANK - 1) : next - first;
        const double* start = starts->configurations + row * JTIK_NQ;
        JTIK_NAME_begin(OF(p).q[here], OF(p).state[here], start, initial, patience, p % JTIK_LANES);
      }
      attempts[p] = (JTIK_NAME_attempt){next++, rounds};
      ++active;
    }
    if (!active || (winner >= 0 && !(nearest && attempts[0].number == 0))) break;
    M over = {0};
    do {
      for (int v = 0; v < JTIK_VECTORS; ++v) {
        double *const *q = memory[v].q, *const *state = memory[v].state, *outcome = memory[v].outcome;
        JTIK_NAME_step(JTIK_ARGUMENTS, (V*)q[1 - here], (V*)state[1 - here], (V*)outcome);
        over |= ((const V*)outcome)[JTIK_CODE] != 0.0;
      }
      here = 1 - here;
      if (++rounds >= JTIK_LONGEST) return tally[0] = JTIK_LOOK;
    } while (!any(over) && rounds < limit);
    for (int p = 0; p < JTIK_TOGETHER; ++p) {
      JTIK_NAME_attempt* own = attempts + p;
      const long long own_code = (long long)OUT(p, CODE);
      long long k = rounds - own->begun;
      if (own->number < 0 || (own_code == 0 && k < limit)) continue;
      if (own_code != 0 && !OUT(p, TRIED)) --k;
      iterations += k;
      const int arrived = own_code == JTIK_DONE ||
                          (k && OUT(p, POSITION_ERROR) <= settings[JTIK_POSITION_TOLERANCE] &&
                           OUT(p, ORIENTATION_ERROR) <= settings[JTIK_ORIENTATION_TOLERANCE]);
      if (arrived && (winner < 0 || own->number == 0 || (won == rounds && own->number < winner))) {
        winner = own->number;
        won = rounds;
        code = own_code;
        for (int j = 0; j < JTIK_NQ; ++j) found[j] = OF(p).q[here][j * JTIK_LANES + p % JTIK_LANES];
        errors[0] = OUT(p, POSITION_ERROR);
        errors[1] = OUT(p, ORIENTATION_ERROR);
      }
      own->number = -1;
      --active;
    }
  }
#undef OF
#undef OUT
  for (int p = 0; p < JTIK_TOGETHER; ++p) iterations += attempts[p].number < 0 ? 0 : rounds - attempts[p].begun;
  tally[1] = iterations;
  tally[2] = next - 1;
  if (winner < 0) return tally[0] = JTIK_EXHAUSTED;
  return tally[0] = JTIK_NAME_turned(at, found) ? JTIK_LOOK : code;
}
"""

RUN = r"""
/* Run the attempts that are prepared, and return what they return. */
static long long JTIK_NAME_run(const JTIK_NAME_solver* at, JTIK_NAME_end* end) {
  const long long *order = at->order, *tally = (const long long*)at->table[2];
  const long long returned = JTIK_NAME_attempts(at->context, (const JTIK_NAME_starts*)order[0], order[1], order[2],
                                                order[3], at->patience[0], at->table);
  *end = (JTIK_NAME_end){(const double*)at->table[0], tally[1], tally[2]};
  return returned;
}
"""
"""What runs them in `jtik._loop.native.solve_source`."""


def sizes(level: Level) -> dict[str, int]:
    """The numbers that the code names, for these instructions."""
    vectors = -(-TOGETHER // level.lanes)
    own = {"TOGETHER": TOGETHER, "VECTORS": vectors, "PLACES": vectors * level.lanes}
    return own | {"NO": len(StepOutcome._fields)}


def work_size(function: Function, level: Level) -> int:
    """How many numbers the attempts need in memory for this step."""
    nq, ns, target = function.numel_out(0), function.numel_out(1), 1 + Inputs._fields.index("target")
    of_vector, vectors = 2 * nq + 2 * ns + len(StepOutcome._fields), sizes(level)["VECTORS"]
    return int(level.lanes * (function.numel_in(target) + vectors * of_vector))
