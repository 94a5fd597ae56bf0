"""Quadratic programs in generated C: what DAQP does before and after its iterations is done here.

DAQP allocates memory for each QP, factorises its matrix by columns of a matrix that lies by rows, and takes time
for each row, also for one without a finite bound, as those of distances beyond their influence are. For a QP of a
robot that takes longer than its iterations. Here memory is on the stack where there is little, rows without a finite
bound are left out, and sums of products are formed side by side. Each number is the result of the same operations in
the same order as in DAQP, so that solutions are the same, bit by bit. What is unusual is left to DAQP: a matrix that is
not positive definite, contradictory bounds, numbers that are not finite.
"""

from __future__ import annotations

import re

_FUNCTIONS = r"""
/* The inverse of the Cholesky factor of H, its rows from the diagonal on one after the other; 0 where there is none.
 * "R" has n rows of "width", the diagonal is apart; "x" is a row. */
static JTIK_INLINED int JTIK_FACTOR(const double* H, const int n, const int width, double* R, double* diagonal,
                                    double* x, double* inverse) {
  int i, j, k, l;
  for (i = 0; i < n; ++i) {
    for (j = 0; j < n; ++j) R[i * width + j] = H[i * n + j];
    for (j = n; j < width; ++j) R[i * width + j] = 0;
  }
  for (i = 0; i < n; ++i) { /* what the rows above leave of row i; what is left of its diagonal is not read */
    double *to = R + i * width, root;
    const int first = i & ~7;
    for (j = first; j < width; j += 8) JTIK_EIGHT(to + j, to + j, R + i, width, R + j, width, i);
    if (!(to[i] > 0)) return 0;
    root = sqrt(to[i]);
    for (j = first; j < width; j += 8) {
      for (l = 0; l < 8; ++l) to[j + l] /= root;
    }
    diagonal[i] = 1 / root;
    for (j = first; j <= i; ++j) to[j] = 0;
  }
  for (k = 0; k < n; inverse += n - k, ++k) {
    const double* from = R + k * width;
    for (j = k & ~7; j < width; j += 8) {
      for (l = 0; l < 8; ++l) x[j + l] = from[j + l] * -diagonal[k];
    }
    inverse[0] = diagonal[k];
    for (i = k + 1; i < n; ++i) {
      const double value = x[i] * diagonal[i];
      inverse[i - k] = value;
      for (j = i & ~7; j < width; j += 8) JTIK_EIGHT(x + j, x + j, &value, 0, R + i * width + j, 0, 1);
    }
  }
  return 1;
}

/* Four rows of A times the inverse, divided by their norms, which "scale" has then; "of" has their columns. Rows that
 * are zero have scale 0. "shift" are the products with v. */
static JTIK_INLINED void JTIK_FOUR_ROWS(const double* of, const int n, const double* inverse, const int diagonal,
                                        const double* v, double smallest, double* M, double* scale, double* shift) {
  double squares[4] = {0}, sums[4] = {0}, norms[4];
  int i, j, l;
  for (j = 0; j < n; ++j) {
    const double* at = diagonal ? inverse + j : inverse + j * n - j * (j - 1) / 2;
    double sum[4];
    for (l = 0; l < 4; ++l) sum[l] = *at * of[4 * j + l];
    for (i = diagonal ? -1 : j - 1; i >= 0; --i) {
      at -= n - 1 - i;
      for (l = 0; l < 4; ++l) sum[l] += *at * of[4 * i + l];
    }
    for (l = 0; l < 4; ++l) M[4 * j + l] = sum[l];
    for (l = 0; l < 4; ++l) squares[l] += sum[l] * sum[l];
  }
  for (l = 0; l < 4; ++l) norms[l] = squares[l] < smallest ? 0 : 1 / sqrt(squares[l]);
  for (j = 0; j < n; ++j) {
    double row[4];
    for (l = 0; l < 4; ++l) row[l] = M[4 * j + l] * norms[l];
    for (l = 0; l < 4; ++l) sums[l] += row[l] * v[j];
    for (l = 0; l < 4; ++l) M[4 * j + l] = row[l];
  }
  for (l = 0; l < 4; ++l) scale[l] = norms[l];
  for (l = 0; l < 4; ++l) shift[l] = sums[l];
}

/* Solve the QP of n variables; 0 where that is left to DAQP. */
static JTIK_INLINED int JTIK_SOLVED_OF(struct casadi_daqp_data* d, const int n) {
  const struct casadi_qp_prob* p = d->prob->qp;
  const struct casadi_qp_data* qp = d->qp;
  const DAQPSettings* settings = &d->prob->settings;
  const int rows = p->na, width = (n + 7) & ~7;
  const double *H = qp->h, *f = qp->g, *A = qp->a;
  DAQPWorkspace* work = &d->work;
  double few[JTIK_FEW], *many = 0, *next = few, *R, *diagonal_of_R, *row, *of, *M, *inverse, *multipliers;
  int i, j, l, m, size, count = 0, diagonal = 1, active = 0, *kept;
  if (!H || !f || !qp->x || !qp->lbx || !qp->ubx || (rows && !(A && qp->lba && qp->uba))) return 0;
  if (p->sp_h[2 + n] != n * n || (rows && p->sp_a[2 + n] != rows * n)) return 0;
  if (d->prob->integrality || settings->eps_prox != 0) return 0;

  for (i = 0; i < rows; ++i) count += qp->lba[i] != -INFINITY || qp->uba[i] != INFINITY;
  m = n + count;
  size = 5 * (n + 1) + (n + 1) * (n + 2) / 2 + n * (n + 1) / 2 + 3 * n + 4 * m + n * count; /* of DAQP */
  size += n * width + n + width + 8 * n + (n + 1 + m + count + 1) / 2;
  if (size > JTIK_FEW && !(next = many = (double*)malloc(size * sizeof(double)))) return 0;
#define JTIK_TAKE(name, number) name = next, next += (number)
  JTIK_TAKE(work->lam, n + 1);
  JTIK_TAKE(work->lam_star, n + 1);
  JTIK_TAKE(work->D, n + 1);
  JTIK_TAKE(work->xldl, n + 1);
  JTIK_TAKE(work->zldl, n + 1);
  JTIK_TAKE(work->L, (n + 1) * (n + 2) / 2);
  JTIK_TAKE(work->u, n);
  JTIK_TAKE(work->xold, n);
  JTIK_TAKE(work->v, n);
  JTIK_TAKE(inverse, n * (n + 1) / 2);
  JTIK_TAKE(work->scaling, m);
  JTIK_TAKE(work->dupper, m);
  JTIK_TAKE(work->dlower, m);
  JTIK_TAKE(multipliers, m);
  JTIK_TAKE(work->M, n * count);
  JTIK_TAKE(R, n * width);
  JTIK_TAKE(diagonal_of_R, n);
  JTIK_TAKE(row, width);
  JTIK_TAKE(of, 4 * n);
  JTIK_TAKE(M, 4 * n);
#undef JTIK_TAKE
  work->WS = (int*)next, work->sense = work->WS + n + 1, kept = work->sense + m;
  work->qp = &d->daqp, work->n = n, work->m = m, work->ms = n;
  work->x = work->u, work->bnb = 0, work->settings = (DAQPSettings*)settings;
  work->sing_ind = EMPTY_IND, work->n_active = work->reuse_ind = 0;
  d->daqp.n = work->n, d->daqp.m = m, d->daqp.ms = n, d->res.x = qp->x;

  for (i = 0; i < n && diagonal; ++i) {
    for (j = i + 1; j < n; ++j) diagonal &= !(H[i * n + j] > 1e-12 || H[i * n + j] < -1e-12);
  }
  if (diagonal) {
    work->Rinv = 0, work->RinvD = inverse;
    for (i = 0; i < n; ++i) {
      if (H[i * n + i] <= 0) goto left;
      work->scaling[i] = sqrt(H[i * n + i]);
      inverse[i] = 1 / work->scaling[i];
      work->v[i] = f[i] * inverse[i];
    }
  } else {
    double* at = inverse + n * (n + 1) / 2;
    work->Rinv = inverse, work->RinvD = 0;
    if (!JTIK_FACTOR(H, n, width, R, diagonal_of_R, row, inverse)) goto left;
    for (i = n - 1; i >= 0; --i) {
      at -= n - i;
      work->v[i] = at[0] * f[i];
      for (j = i + 1; j < n; ++j) work->v[j] += at[j - i] * f[i];
    }
  }

  for (i = j = 0; i < rows; ++i) {
    if (qp->lba[i] != -INFINITY || qp->uba[i] != INFINITY) kept[j++] = i;
  }
  for (i = 0; i < count; i += 4) {
    double scale[4], shift[4];
    int which[4];
    for (l = 0; l < 4; ++l) which[l] = kept[i + l < count ? i + l : count - 1];
    for (j = 0; j < n; ++j) {
      for (l = 0; l < 4; ++l) of[4 * j + l] = A[j * rows + which[l]];
    }
    JTIK_FOUR_ROWS(of, n, inverse, diagonal, work->v, settings->zero_tol, M, scale, shift);
    for (l = 0; l < 4 && i + l < count; ++l) {
      const double low = qp->lba[which[l]], high = qp->uba[which[l]];
      const int at = n + i + l;
      if (scale[l] == 0) { /* DAQP does not look at it */
        work->sense[at] = IMMUTABLE, work->scaling[at] = 1;
      } else if (low == high || high - low < settings->zero_tol) {
        work->sense[at] = ACTIVE + IMMUTABLE, work->scaling[at] = scale[l], active = 1;
        if (high - low < -settings->primal_tol) goto left;
      } else {
        work->sense[at] = 0, work->scaling[at] = scale[l];
      }
      work->dupper[at] = high * work->scaling[at] + shift[l];
      work->dlower[at] = low * work->scaling[at] + shift[l];
      for (j = 0; j < n; ++j) work->M[(i + l) * n + j] = M[4 * j + l];
    }
  }

  for (i = 0; i < n; ++i) {
    const double low = qp->lbx[i], high = qp->ubx[i];
    double shift = 0;
    if (diagonal) {
      shift = work->v[i];
    } else { /* its row of the inverse, divided by its norm */
      double squares = 0;
      for (j = 0; j < n - i; ++j) squares += inverse[j] * inverse[j];
      work->scaling[i] = 1 / sqrt(squares);
      for (j = 0; j < n - i; ++j) {
        inverse[j] *= work->scaling[i];
        shift += inverse[j] * work->v[i + j];
      }
      inverse += n - i;
    }
    work->dupper[i] = high * work->scaling[i] + shift;
    work->dlower[i] = low * work->scaling[i] + shift;
    work->sense[i] = 0;
    if (low == high || high - low < settings->zero_tol) {
      work->sense[i] = ACTIVE + IMMUTABLE, active = 1;
      if (high - low < -settings->primal_tol) goto left;
    }
  }

  if (active && activate_constraints(work) < 0) goto left;
  d->res.lam = multipliers; /* from here on nothing is left to DAQP, which has memory of its own for them */
  d->return_status = d->res.exitflag = daqp_ldp(work);
  if (d->res.exitflag > 0) ldp2qp_solution(work);
  daqp_extract_result(&d->res, work);
  d->nodecount = d->bnb_itercount = 0;
  d->qp->success = d->res.exitflag == EXIT_OPTIMAL;
  if (qp->f) *qp->f = d->res.fval;
  casadi_copy(d->res.lam, n, qp->lam_x);
  if (qp->lam_a) {
    casadi_clear(qp->lam_a, rows);
    for (i = 0; i < count; ++i) qp->lam_a[kept[i]] = d->res.lam[n + i];
  }
  free(many);
  return 1;
left:
  free(many);
  return 0;
}

/* The same for the numbers of variables that there are: loops of a known length take less time. */
static int JTIK_SOLVED(struct casadi_daqp_data* d) {
  switch (d->prob->qp->nx) {
JTIK_CASES
  }
  return 0;
}

"""

FEW = 1500
"""Most numbers in the memory of a QP for which it is on the stack."""

_SOLVE = "int casadi_daqp_solve(struct casadi_daqp_data* d, "
_BEGIN = "  struct casadi_qp_data* d_qp = d->qp;\n"
_API = "#include <daqp/api.h>\n"
_VARIABLES = re.compile(r"^/\* \w+:\(h\[(\d+)x\1\],g\[", re.MULTILINE)


def with_own_setup(source: str) -> str:
    """Generated C that does so; the same text where it does not call DAQP as that of CasADi 3.8 does.

    Args:
        source: the generated C.
    """
    parts = source.partition(_SOLVE)
    if any(source.count(part) != 1 for part in (_SOLVE, _API)) or _BEGIN not in parts[2] or "_solved)(d)" in source:
        return source
    begun = parts[2].replace(_BEGIN, _BEGIN + "  if (JTIK_SOLVED(d)) return 0;\n", 1)
    cases = [f"    case {n}: return JTIK_SOLVED_OF(d, {n});" for n in sorted(set(_VARIABLES.findall(source)), key=int)]
    source = "".join((parts[0], _FUNCTIONS.replace("JTIK_CASES", "\n".join(cases)), parts[1], begun)).replace(
        _API, _API + "#include <stdlib.h>\n"
    )
    for name in ("SOLVED_OF", "SOLVED", "FACTOR", "FOUR_ROWS"):
        source = source.replace(f"JTIK_{name}", f"CASADI_PREFIX(daqp_{name.lower()})")
    return source.replace("JTIK_FEW", str(FEW))
