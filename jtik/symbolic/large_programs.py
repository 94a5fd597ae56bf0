"""Quadratic programs of many variables: generated C factorises their matrix for DAQP.

DAQP begins with the inverse of the Cholesky factor R of the matrix, R' R = P, and forms it by columns of a matrix that
lies in memory by rows: with 100 variables that takes most of the time of a solve. Here it is formed by rows, with the
same operations on each of its numbers, so that solutions are the same, bit by bit.
"""

from __future__ import annotations

LEAST = 20
"""Fewest variables of such a program: with 16 the time is the same."""

_FUNCTION = r"""
/* R of H = R' R in the place of H, the reciprocals of its diagonal on it; 0 where H is not positive definite. What is
 * under the diagonal is not read: the last eight numbers of a row may overlap it. */
static int JTIK_CHOLESKY(double* H, int n, double* row) {
  const int last = n - 8;
  int i, j, k;
  for (i = 0; i < n; ++i) { /* what the rows above leave of row i */
    double *to = H + i * n, root;
    for (j = i < last ? i : last; j < n; ++j) row[j] = to[j];
    for (j = i; j < n; j += 8) {
      k = j < last ? j : last;
      JTIK_EIGHT(to + k, row + k, H + i, n, H + k, n, i);
    }
    if (to[i] <= 0) return 0;
    root = sqrt(to[i]);
    for (j = i + 1; j < n; ++j) to[j] /= root;
    to[i] = 1 / root;
  }
  return 1;
}

/* The inverse of R, its rows from the diagonal on one after the other. */
static void JTIK_INVERSE(const double* R, int n, double* inverse) {
  int i, j, k;
  for (k = 0; k < n; inverse += n - k, ++k) {
    double* x = inverse - k;
    x[k] = R[k * n + k];
    for (j = k + 1; j < n; ++j) x[j] = R[k * n + j] * -x[k];
    for (i = k + 1; i < n; ++i) {
      const double *r = R + i * n, value = x[i] * r[i];
      x[i] = value;
      JTIK_INDEPENDENT
      for (j = i + 1; j < n; ++j) x[j] -= r[j] * value;
    }
  }
}

/* What setup_daqp does. It is called for the identity, and the rest then done for H. */
static int JTIK_SETUP(DAQPProblem* p, DAQPWorkspace* work) {
  const int n = p->n, mask = UPDATE_Rinv | UPDATE_M | UPDATE_v | UPDATE_d | UPDATE_sense;
  int i, j, flag, diagonal = 1, *sense;
  double *R, *memory;
  if (n < JTIK_LEAST || p->ms != n) return setup_daqp(p, work, 0);
  for (i = 0; i < n && diagonal; ++i) {
    for (j = i + 1; j < n; ++j) diagonal &= p->H[i * n + j] == 0;
  }
  memory = diagonal ? 0 : (double*)malloc(sizeof(double) * (n * n + n) + sizeof(int) * p->m);
  if (!memory) return setup_daqp(p, work, 0);
  R = memory + n, sense = (int*)(R + n * n);
  for (i = 0; i < n * n; ++i) R[i] = p->H[i];
  if (!JTIK_CHOLESKY(R, n, memory)) {
    free(memory);
    return setup_daqp(p, work, 0);
  }
  for (i = 0; i < n; ++i) {
    for (j = 0; j < n; ++j) p->H[i * n + j] = i == j;
  }
  for (i = 0; i < p->m; ++i) sense[i] = p->sense[i], p->sense[i] = 0;
  flag = setup_daqp(p, work, 0);
  for (i = 0; i < p->m; ++i) p->sense[i] = sense[i];
  if (flag >= 0) {
    work->Rinv = work->RinvD, work->RinvD = 0;
    JTIK_INVERSE(R, n, work->Rinv);
    for (i = 0; i < p->m; ++i) work->sense[i] = sense[i];
    update_M(work, mask);
    normalize_M(work);
    update_v(p->f, work, mask);
    normalize_Rinv(work);
    update_d(work);
    flag = activate_constraints(work);
    if (flag < 0) {
      work->settings = 0; /* they are not on the heap */
      free_daqp_workspace(work);
      free_daqp_ldp(work);
    }
  }
  free(memory);
  return flag;
}

"""

_SOLVE = "int casadi_daqp_solve(struct casadi_daqp_data* d, "
_SETUP = "  flag = setup_daqp(&d->daqp,&d->work,0);\n"
_OWN = "  flag = JTIK_SETUP(&d->daqp, &d->work);\n"
_API = "#include <daqp/api.h>\n"


def with_own_factors(source: str) -> str:
    """Generated C that does so; the same text where it does not call DAQP as `without_unbounded_rows` leaves it.

    Args:
        source: the generated C.
    """
    if any(source.count(part) != 1 for part in (_SOLVE, _SETUP, _API)):
        return source
    source = source.replace(_SOLVE, _FUNCTION + _SOLVE).replace(_SETUP, _OWN)
    for name in ("SETUP", "CHOLESKY", "INVERSE"):
        source = source.replace(f"JTIK_{name}", f"CASADI_PREFIX(own_{name.lower()})")
    return source.replace(_API, _API + "#include <daqp/utils.h>\n#include <stdlib.h>\n").replace(
        "JTIK_LEAST", str(LEAST)
    )
