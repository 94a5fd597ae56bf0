"""Products of dense matrices in generated C, with the loop over the rows inside, which compilers make vectors of.

Each entry of the product is summed in the same order as in CasADi's own loops, and has the same bits.
"""

from __future__ import annotations

_INNER = """\
    for (i=0; i<ncol_y; ++i) {
      for (j=0; j<nrow_x; ++j) {
        for (k=0; k<ncol_x; ++k) {
          z[j + i*nrow_x] += x[j + k*nrow_x] * y[k + i*ncol_x];
        }
      }
    }
"""

_FAST = """\
    if (nrow_x>3) {
      for (i=0; i<ncol_y; ++i) {
        for (k=0; k<ncol_x; ++k) {
          const casadi_real t = y[k + i*ncol_x];
          for (j=0; j<nrow_x; ++j) z[j + i*nrow_x] += x[j + k*nrow_x] * t;
        }
      }
      return;
    }
"""


def with_fast_products(source: str) -> str:
    """Generated C with these loops; the same text where it has no product of matrices as CasADi 3.8 writes it."""
    return source.replace(_INNER, _FAST + _INNER)
