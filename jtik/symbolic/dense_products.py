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
        k = 0;
        for (; nrow_x>63 && k+3<ncol_x; k+=4) {
          const casadi_real *x0 = x+k*nrow_x, *x1 = x0+nrow_x, *x2 = x1+nrow_x, *x3 = x2+nrow_x, *t = y+k+i*ncol_x;
          const casadi_real t0 = t[0], t1 = t[1], t2 = t[2], t3 = t[3];
          casadi_real* to = z + i*nrow_x;
          JTIK_INDEPENDENT
          for (j=0; j<nrow_x; ++j) to[j] = to[j] + x0[j]*t0 + x1[j]*t1 + x2[j]*t2 + x3[j]*t3;
        }
        for (; k<ncol_x; ++k) {
          const casadi_real t = y[k + i*ncol_x];
          for (j=0; j<nrow_x; ++j) z[j + i*nrow_x] += x[j + k*nrow_x] * t;
        }
      }
      return;
    }
    if (nrow_x==1) {
      for (i=0; i+3<ncol_y; i+=4) {
        const casadi_real *y0=y+i*ncol_x, *y1=y0+ncol_x, *y2=y1+ncol_x, *y3=y2+ncol_x;
        casadi_real z0=z[i], z1=z[i+1], z2=z[i+2], z3=z[i+3];
        for (k=0; k<ncol_x; ++k) z0+=x[k]*y0[k], z1+=x[k]*y1[k], z2+=x[k]*y2[k], z3+=x[k]*y3[k];
        z[i]=z0, z[i+1]=z1, z[i+2]=z2, z[i+3]=z3;
      }
      y += i*ncol_x, z += i, ncol_y -= i;
    }
"""


def with_fast_products(source: str) -> str:
    """Generated C with these loops; the same text where it has no product of matrices as CasADi 3.8 writes it.

    Args:
        source: the generated C.
    """
    return source.replace(_INNER, _FAST + _INNER)
