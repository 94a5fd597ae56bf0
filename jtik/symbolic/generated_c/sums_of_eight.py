"""Eight sums of products side by side in generated C: what factorisations of large matrices spend their time in."""

from __future__ import annotations

SUMS_OF_EIGHT = r"""
/* Eight numbers in a row: "from" less the products of "count" factors, "skip" apart, with rows, "stride" apart. */
static JTIK_INLINED void JTIK_EIGHT(double* to, const double* from, const double* factors, int skip, const double* row,
                                    int stride, int count) {
  double sums[8];
  int k, l;
  for (l = 0; l < 8; ++l) sums[l] = from[l];
  for (k = 0; k < count; ++k, row += stride, factors += skip) {
    for (l = 0; l < 8; ++l) sums[l] -= *factors * row[l];
  }
  for (l = 0; l < 8; ++l) to[l] = sums[l];
}
"""


def with_sums_of_eight(source: str) -> str:
    """Generated C with ``JTIK_EIGHT`` before it where it is called.

    Args:
        source: the generated C.
    """
    return SUMS_OF_EIGHT + source if "JTIK_EIGHT(" in source else source
