"""The C code of the native search; every index in it comes from the named structures."""

from __future__ import annotations

from collections.abc import Mapping

from jtik._loop.native import start_bank_source
from jtik._loop.search.full_turns import FARTHEST, ROUNDING, TURN
from jtik._step.inputs import SETTING, Inputs
from jtik._step.stopping import OUTCOME, Code
from jtik._step.vector_layout import VectorLayout

LOOK, EXHAUSTED, UNREADABLE = -1, -2, -3
"""What the search in C returns besides the code of a call."""

BUDGET = 0.1
"""Time after which a call of C returns, unfinished, so that Python can obey Ctrl-C [s]."""

CHECKED = 1024
"""Calls of one attempt after which the time is read."""

_INCLUDED = """
#include <math.h>
#include <string.h>
#include <time.h>
"""

TURNED = r"""
/* Joints that move without limits: each to the turn within its limits nearest to q0. Returns 1 where none fits, or
   where another turn may change the criterion; q is then as it was. */
static int JTIK_NAME_turned(void** at, double* q) {
  const double* q0 = (const double*)at[12];
  const long long count = (long long)at[15], criterion = (long long)at[16];
  const long long* index = (const long long*)at[17];
  const double *lower = (const double*)at[18], *upper = (const double*)at[19];
  int needed = 1;
  for (int write = 0; write < 2 && needed; ++write) {
    needed = write;
    for (long long i = 0; i < count; ++i) {
      const double own = q[index[i]];
      const double least = ceil((lower[i] - own - JTIK_ROUNDING) / JTIK_TURN);
      const double most = floor((upper[i] - own + JTIK_ROUNDING) / JTIK_TURN);
      double turns = rint((q0[index[i]] - own) / JTIK_TURN);
      if (fabs(own + turns * JTIK_TURN) > JTIK_FARTHEST) turns = 0;
      if (turns < least) turns = least;
      if (turns > most) turns = most;
      if (least > most || (criterion && turns != 0)) return 1;
      needed |= turns != 0 || own < lower[i] || own > upper[i];
      if (write) {
        double moved = own + turns * JTIK_TURN;
        if (moved < lower[i]) moved = lower[i];
        if (moved > upper[i]) moved = upper[i];
        q[index[i]] = moved;
      }
    }
  }
  return 0;
}

static double JTIK_NAME_seconds(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}
"""

_SOURCE = r"""
/* Attempts number from to last of a search, until one reaches the target. starts: NULL without restarts; row 0 of the
   configurations is attempt number first.
   Returns its code; or JTIK_LOOK: the search in Python takes over this attempt; or JTIK_EXHAUSTED: none reached it, or
   the time JTIK_BUDGET is over, and the attempts after tally[1] are left; or JTIK_UNREADABLE: q0 is not finite. */
CASADI_SYMBOL_EXPORT long long JTIK_NAME_search(void** at, const JTIK_NAME_starts* starts, long long first,
                                                long long from, long long last, long long limit, double patience) {
  const double** arg = (const double**)at[0];
  double** res = (double**)at[1];
  long long* iw = (long long*)at[2];
  double* w = (double*)at[3];
  double* q[2] = {(double*)at[4], (double*)at[5]};
  double* state[2] = {(double*)at[6], (double*)at[7]};
  double* outcome = (double*)at[8];
  const double* initial = (const double*)at[9];
  double* settings = (double*)at[10];
  long long* tally = (long long*)at[11]; /* in the order of Tally */
  const double* q0 = (const double*)at[12];
  const size_t nq = ((size_t)at[13]) * sizeof(double), ns = ((size_t)at[14]) * sizeof(double);
  double* best = (double*)at[20]; /* smallest V of an attempt that did not reach the target */
  tally[0] = 0;
  tally[4] = -1;
  if (from == 0) best[0] = INFINITY;
  for (long long j = 0; j < (long long)at[13]; ++j) {
    if (!(q0[j] - q0[j] == 0)) return JTIK_UNREADABLE;
  }
  const int several = starts != 0;
  const long long size = several ? starts->size : 0;
  int32_t* keys = (int32_t*)at[24];
  int32_t nearest = JTIK_FIRST; /* key of the latest one that has been tried */
  long long ranked = 0;         /* how many of the bank have been */
  const double end = limit > JTIK_CHECKED || several ? JTIK_NAME_seconds() + JTIK_BUDGET : 0;
  for (long long number = from; number <= last; ++number) {
    long long k = 0, here = 0, code = 0;
    if (0 < number && number <= size) {
      if (!ranked) JTIK_NAME_keys(keys, starts, arg[JTIK_TARGET], (int)(long long)at[23]);
      for (; ranked < number; ++ranked) nearest = JTIK_NAME_following(keys, nearest);
    }
    const long long row = number <= size ? nearest & (JTIK_BANK - 1) : number - first;
    memcpy(q[0], number ? starts->configurations + row * (long long)at[13] : q0, nq);
    memcpy(state[0], initial, ns);
    if (patience < INFINITY) state[0][JTIK_PATIENCE] = patience;
    while (k < limit && code == 0) {
      arg[0] = q[here];
      arg[JTIK_STATE] = state[here];
      res[0] = q[1 - here];
      res[1] = state[1 - here];
      res[2] = outcome;
      if (JTIK_NAME(arg, res, iw, w, 0) || (long long)outcome[JTIK_CODE] == JTIK_UNSOLVED) {
        tally[1] = number; /* the search in Python repeats this call, with another solver */
        tally[2] = here;
        tally[3] = k;
        tally[5] = 0;
        return JTIK_LOOK;
      }
      here = 1 - here;
      ++k;
      code = (long long)outcome[JTIK_CODE];
      if (k % JTIK_CHECKED == 0 && code == 0 && k < limit && JTIK_NAME_seconds() > end) break; /* Python goes on */
    }
    tally[1] = number;
    tally[2] = here;
    tally[3] = k;
    tally[5] = code;
    if (code == 0 && k < limit) return JTIK_LOOK;
    if (code == JTIK_STALLED && (k == 1 || !several)) return JTIK_LOOK;
    if (code == JTIK_SLOW && !several) return JTIK_LOOK;
    if (code != 0 && !outcome[JTIK_TRIED]) --k; /* the call stopped before it tried a step: not an iteration */
    if (!several || code == JTIK_DONE ||
        (k && outcome[JTIK_POSITION_ERROR] <= settings[JTIK_POSITION_TOLERANCE] &&
         outcome[JTIK_ORIENTATION_ERROR] <= settings[JTIK_ORIENTATION_TOLERANCE])) {
      if (JTIK_NAME_turned(at, q[here])) return JTIK_LOOK;
      tally[0] += k;
      tally[3] = k;
      return code;
    }
    tally[0] += k;
    if (number == 0) memcpy((double*)at[22], q[here], nq);
    if (number == 0 || outcome[JTIK_V] < best[0]) {
      best[0] = outcome[JTIK_V];
      tally[4] = number;
      memcpy((double*)at[21], q[here], nq);
    }
    if (number < last && JTIK_NAME_seconds() > end) break;
  }
  return JTIK_EXHAUSTED;
}

/* The same for a table of targets, one after the other, each from its row of starts (stride 0: the same for all).
   Returns how many are done when the time is over. */
CASADI_SYMBOL_EXPORT long long JTIK_NAME_batch(void** at, const JTIK_NAME_starts* starts, long long first,
                                               long long last, long long limit, double patience, void** table) {
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
  double before = JTIK_NAME_seconds();
  const double end = before + JTIK_BUDGET;
  for (size_t i = 0; i < count; ++i) {
    memcpy(target, targets + i * size, size * sizeof(double));
    memcpy((double*)at[12], from + i * stride, nq * sizeof(double));
    tallies[3 * i] = JTIK_NAME_search(at, starts, first, 0, last, limit, patience);
    tallies[3 * i + 1] = tally[0];
    tallies[3 * i + 2] = tally[1];
    memcpy(ends + i * nq, (double*)at[4 + tally[2]], nq * sizeof(double));
    errors[2 * i] = outcome[JTIK_POSITION_ERROR];
    errors[2 * i + 1] = outcome[JTIK_ORIENTATION_ERROR];
    const double now = JTIK_NAME_seconds();
    seconds[i] = now - before;
    before = now;
    if (now > end) return (long long)i + 1;
  }
  return (long long)count;
}
"""

RUN = r"""
/* Run the search that is prepared, and return what it returns. */
static long long JTIK_NAME_run(const JTIK_NAME_solver* at, JTIK_NAME_end* end) {
  const long long *order = at->order, *tally = (const long long*)at->context[11];
  const JTIK_NAME_starts* starts = (const JTIK_NAME_starts*)order[0];
  const long long returned =
      JTIK_NAME_search(at->context, starts, order[1], 0, order[2], order[3], at->patience[0]);
  *end = (JTIK_NAME_end){(const double*)at->context[4 + tally[2]], tally[0], tally[1]};
  return returned;
}
"""
"""What runs this search in `jtik._loop.native.solve_source`."""


def source(state: VectorLayout) -> str:
    """The C code for a step whose state has this layout."""
    return f"{macros(state)}{_INCLUDED}{TURNED}{start_bank_source.SOURCE}{_SOURCE}"


def macros(state: VectorLayout) -> str:
    """The numbers that the C code names: every index comes from the named structures."""
    integers = {"CHECKED": CHECKED, "LOOK": LOOK, "EXHAUSTED": EXHAUSTED, "UNREADABLE": UNREADABLE}
    numbers = {"TURN": TURN, "FARTHEST": FARTHEST, "ROUNDING": ROUNDING, "BUDGET": BUDGET}
    return defined(indices(state) | integers | numbers)


def indices(state: VectorLayout) -> dict[str, int]:
    """The codes of a call, and where it reads and writes what, for a step whose state has this layout."""
    first = 1  # q is argument 0
    return {
        **{code.name: int(code) for code in Code},
        "PATIENCE": state.slices["patience"].start,
        "STATE": first + len(Inputs._fields),
        **{name.upper(): first + i for i, name in enumerate(Inputs._fields)},
        "POSITION_TOLERANCE": SETTING.position_tolerance,
        "ORIENTATION_TOLERANCE": SETTING.orientation_tolerance,
        **{name.upper(): index for name, index in OUTCOME._asdict().items()},
    }


def defined(constants: Mapping[str, float]) -> str:
    """Constants of C, each with the prefix ``JTIK_``; the same may be defined twice."""
    return "\n" + "".join(f"#define JTIK_{name} {value!r}\n" for name, value in constants.items())
