"""The C code that finishes searches which single precision has brought close to their targets.

Most of them are within the tolerances, or one step in double precision away. Whether they are takes the errors alone, a
third of a step.
"""

from __future__ import annotations

from jtik._step.stopping import OUTCOME
from jtik.symbolic import Function, function, vertcat
from jtik.symbolic.lanes.source import lane_source

FINISHED = -2
"""In place of the steps after which an attempt has come close: its search has ended there; one less: after a step."""

_SOURCE = r"""
/* What the search in single precision has found, several ends side by side: where one meets the target, or a step from
   it does, the search has ended. The others are left as they are. The table is that of JTIK_NAME_lanes. */
static JTIK_CPU void JTIK_NAME_refine(void** at, long long limit, double patience, void** table) {
  const double* targets = (const double*)table[0];
  const double* from = (const double*)table[1];
  double* ends = (double*)table[2];
  double* errors = (double*)table[3];
  double* seconds = (double*)table[4];
  long long* tallies = (long long*)table[5]; /* code, iterations, restarts */
  const long long count = (long long)table[6], stride = (long long)table[8];
  long long* arrived_after = (long long*)table[10];
  const double* const* shared = (const double* const*)at[0];
  const double* initial = (const double*)at[9];
  const double* settings = shared[JTIK_SETTINGS];
  double* q[2] = {(double*)table[9], (double*)table[9] + JTIK_NQ * JTIK_LANES};
  double* state[2] = {q[1] + JTIK_NQ * JTIK_LANES, q[1] + (JTIK_NQ + JTIK_NS) * JTIK_LANES};
  double* target = state[1] + JTIK_NS * JTIK_LANES;
  double* outcome = target + JTIK_NT * JTIK_LANES;
  double begin = JTIK_NAME_seconds(), mean[2];
  long long rows[JTIK_LANES];
  for (int steps = 0; steps < 2; ++steps) { /* at the ends themselves, and after a step from those that are left */
    long long begun = 0;
    for (long long next = 0; next < count;) {
      int own = 0, here = 0;
      for (; next < count && own < JTIK_LANES; ++next) {
        if (arrived_after[next] >= 0 && arrived_after[next] < limit - steps) rows[own++] = next;
      }
      if (!own) break;
      for (int i = 0; i < JTIK_LANES; ++i) {
        const long long row = rows[i < own ? i : 0];
        for (int j = 0; j < JTIK_NT; ++j) target[j * JTIK_LANES + i] = targets[row * JTIK_NT + j];
        JTIK_NAME_begin(q[0], state[0], ends + row * JTIK_NQ, initial, patience, i);
      }
      V found[2];
      M arrived = ~(M){0};
      if (steps) {
        JTIK_NAME_step(JTIK_ARGUMENTS, (V*)q[1], (V*)state[1], (V*)outcome);
        arrived = ((const V*)outcome)[JTIK_CODE] == 0;
        here = 1;
      }
      JTIK_NAME_errors(JTIK_ARGUMENTS, found);
      arrived &= (found[0] <= settings[JTIK_POSITION_TOLERANCE]) & (found[1] <= settings[JTIK_ORIENTATION_TOLERANCE]);
      for (int i = 0; i < own; ++i) {
        if (!arrived[i]) continue;
        const long long row = rows[i];
        double* end = ends + row * JTIK_NQ;
        for (int j = 0; j < JTIK_NQ; ++j) end[j] = q[here][j * JTIK_LANES + i];
        memcpy((double*)at[12], from + row * stride, JTIK_NQ * sizeof(double));
        tallies[3 * row] = JTIK_NAME_turned(at, end) ? JTIK_LOOK : JTIK_DONE;
        tallies[3 * row + 1] += arrived_after[row] + steps;
        errors[2 * row] = found[0][i];
        errors[2 * row + 1] = found[1][i];
        arrived_after[row] = JTIK_FINISHED - steps;
      }
      begun += own;
    }
    const double now = JTIK_NAME_seconds();
    mean[steps] = begun ? (now - begin) / begun : 0;
    begin = now;
  }
  for (long long row = 0; row < count; ++row) {
    if (arrived_after[row] != -1) seconds[row] += mean[0];
    if (arrived_after[row] != -1 && arrived_after[row] != JTIK_FINISHED) seconds[row] += mean[1];
  }
}
"""


def source(step: Function, shared: list[int]) -> str:
    """The C code, which follows that of the step and of what begins an attempt.

    Args:
        step: the fused step.
        shared: as in `jtik.symbolic.lanes.source.lane_source`.
    """
    symbols = step.sx_in()
    outcome = step.call(symbols)[2]
    both = vertcat(outcome[OUTCOME.position_error], outcome[OUTCOME.orientation_error])
    return lane_source(function("errors", symbols, [both]), "JTIK_NAME_errors", shared) + _SOURCE
