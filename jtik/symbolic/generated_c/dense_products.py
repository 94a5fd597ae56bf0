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
        const casadi_real* t = y + i*ncol_x;
        casadi_real* to = z + i*nrow_x;
        casadi_int l;
        for (j=0; j+15<nrow_x; j+=16) {
          casadi_real sums[16];
          for (l=0; l<16; ++l) sums[l] = to[j+l];
          for (k=0; k<ncol_x; ++k) {
            for (l=0; l<16; ++l) sums[l] += x[j + l + k*nrow_x] * t[k];
          }
          for (l=0; l<16; ++l) to[j+l] = sums[l];
        }
        for (k=0; j<nrow_x && k<ncol_x; ++k) {
          for (l=j; l<nrow_x; ++l) to[l] += x[l + k*nrow_x] * t[k];
        }
      }
      return;
    }
    if (nrow_x==1) {
      for (i=0; i+7<ncol_y; i+=8) {
        const casadi_real *y0=y+i*ncol_x, *y1=y0+ncol_x, *y2=y1+ncol_x, *y3=y2+ncol_x;
        const casadi_real *y4=y3+ncol_x, *y5=y4+ncol_x, *y6=y5+ncol_x, *y7=y6+ncol_x;
        casadi_real z0=z[i], z1=z[i+1], z2=z[i+2], z3=z[i+3], z4=z[i+4], z5=z[i+5], z6=z[i+6], z7=z[i+7];
        for (k=0; k<ncol_x; ++k) {
          z0+=x[k]*y0[k], z1+=x[k]*y1[k], z2+=x[k]*y2[k], z3+=x[k]*y3[k];
          z4+=x[k]*y4[k], z5+=x[k]*y5[k], z6+=x[k]*y6[k], z7+=x[k]*y7[k];
        }
        z[i]=z0, z[i+1]=z1, z[i+2]=z2, z[i+3]=z3, z[i+4]=z4, z[i+5]=z5, z[i+6]=z6, z[i+7]=z7;
      }
      for (; i+1<ncol_y; i+=2) {
        const casadi_real *y0=y+i*ncol_x, *y1=y0+ncol_x;
        casadi_real z0=z[i], z1=z[i+1];
        for (k=0; k<ncol_x; ++k) z0+=x[k]*y0[k], z1+=x[k]*y1[k];
        z[i]=z0, z[i+1]=z1;
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
