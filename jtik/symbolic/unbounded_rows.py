"""Rows of a quadratic program without a finite bound: generated C leaves them out before DAQP.

They are those of distances beyond their influence. DAQP takes time for each row that it is given, and solves the
program in the same steps, and to the same bits, without them. Nor is it asked for the time that its set-up takes.
"""

from __future__ import annotations

_FUNCTION = r"""
/* Keep only the rows with a finite bound: "kept" are their numbers. Returns how many. */
static int JTIK_ROWS(DAQPProblem* p, int* kept) {
  const int n = p->n, rows = p->m - p->ms;
  double *low = p->blower + n, *high = p->bupper + n;
  int count = 0;
  for (int i = 0; i < rows; ++i) {
    if (low[i] == -INFINITY && high[i] == INFINITY) continue;
    if (count != i) {
      for (int j = 0; j < n; ++j) p->A[count * n + j] = p->A[i * n + j];
      low[count] = low[i], high[count] = high[i], p->sense[n + count] = p->sense[n + i];
    }
    kept[count++] = i;
  }
  p->m = p->ms + count;
  return count;
}

"""

_SOLVE = "int casadi_daqp_solve(struct casadi_daqp_data* d, "
_SETUP = "  flag = setup_daqp(&d->daqp,&d->work,&(d->res.setup_time));\n"
_UNTIMED = _SETUP.replace("&(d->res.setup_time)", "0")
_MULTIPLIERS = "  casadi_copy(d->res.lam+p_qp->nx, p_qp->na, d_qp->lam_a);\n"

_BEFORE = """\
  int* kept = d->daqp.sense + p->qp->nz; /* integers of CasADi are twice as long: the second half is free */
  const int count = JTIK_ROWS(&d->daqp, kept);
"""

_AFTER = """\
  if (d_qp->lam_a) {
    casadi_clear(d_qp->lam_a, p_qp->na);
    for (i = 0; i < count; ++i) d_qp->lam_a[kept[i]] = d->res.lam[p_qp->nx + i];
  }
"""


def without_unbounded_rows(source: str) -> str:
    """Generated C that leaves out such rows; the same text where it does not call DAQP as that of CasADi 3.8 does.

    Args:
        source: the generated C.
    """
    if any(source.count(part) != 1 for part in (_SOLVE, _SETUP, _MULTIPLIERS)):
        return source
    source = source.replace(_SOLVE, _FUNCTION + _SOLVE).replace(_SETUP, _BEFORE + _UNTIMED)
    return source.replace(_MULTIPLIERS, _AFTER).replace("JTIK_ROWS", "CASADI_PREFIX(daqp_rows)")
