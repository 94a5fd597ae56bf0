"""Rows of a quadratic program that no point of its box brings to a bound: generated C leaves them out before DAQP.

They are not active in any solution, and DAQP's setup, its largest part beside a few active rows, takes time for each.
"""

from __future__ import annotations

MARGIN = 1e-9
"""How far inside its bounds a row stays in the whole box, relative to 1 and the row's value: more than rounding."""

_FUNCTION = r"""
/* Whether sign * row x stays above a bound for every x of a box; 0 also where that is infinite. */
static int JTIK_IDLE(const double* row, const double* lower, const double* width, int n, double sign, double bound) {
  double least = 0;
  for (int j = 0; j < n; ++j) {
    const double entry = sign * row[j], change = entry * width[j];
    least += entry * lower[j] + (change < 0 ? change : 0);
  }
  return least - JTIK_MARGIN * (1 + fabs(least)) > bound;
}

/* Keep only the rows that a point of the box may bring to a bound: "kept" are their numbers. Returns how many. */
static int JTIK_ROWS(DAQPProblem* p, double* width, int* kept) {
  const int n = p->n, rows = p->m - p->ms;
  double *low = p->blower + n, *high = p->bupper + n;
  int count = 0;
  for (int j = 0; j < n; ++j) width[j] = p->bupper[j] - p->blower[j];
  for (int i = 0; i < rows; ++i) {
    const double* row = p->A + i * n;
    if ((low[i] == -INFINITY || JTIK_IDLE(row, p->blower, width, n, 1, low[i])) &&
        (high[i] == INFINITY || JTIK_IDLE(row, p->blower, width, n, -1, -high[i]))) continue;
    if (count != i) {
      for (int j = 0; j < n; ++j) p->A[count * n + j] = row[j];
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
_MULTIPLIERS = "  casadi_copy(d->res.lam+p_qp->nx, p_qp->na, d_qp->lam_a);\n"

_BEFORE = """\
  int* kept = d->daqp.sense + p->qp->nz; /* integers of CasADi are twice as long: the second half is free */
  const int count = JTIK_ROWS(&d->daqp, d->res.lam, kept);
"""

_AFTER = """\
  if (d_qp->lam_a) {
    casadi_clear(d_qp->lam_a, p_qp->na);
    for (i = 0; i < count; ++i) d_qp->lam_a[kept[i]] = d->res.lam[p_qp->nx + i];
  }
"""


def without_idle_rows(source: str) -> str:
    """Generated C that leaves out such rows; the same text where it does not call DAQP as CasADi 3.7 and 3.8 do.

    Args:
        source: the generated C.
    """
    if any(source.count(part) != 1 for part in (_SOLVE, _SETUP, _MULTIPLIERS)):
        return source
    rows = _FUNCTION.replace("JTIK_MARGIN", repr(MARGIN))
    source = source.replace(_SOLVE, rows + _SOLVE).replace(_SETUP, _BEFORE + _SETUP)
    source = source.replace(_MULTIPLIERS, _AFTER).replace("JTIK_ROWS", "CASADI_PREFIX(daqp_rows)")
    return source.replace("JTIK_IDLE", "CASADI_PREFIX(daqp_idle)")
