"""The C code that reads matrices as the targets of a batch, several side by side."""

from __future__ import annotations

from jtik.symbolic import Function
from jtik.symbolic.lanes.source import has_lanes, lane_source

_SOURCE = r"""
/* Read so many matrices (4, 4), row by row, as targets; whether all of them are valid. */
JTIK_CPU long long JTIK_NAME_matrices(const double* matrices, long long count, double* targets) {
  V entries[16], target[JTIK_NT], valid[1];
  M wrong = {0};
  for (long long k = 0; k < count; k += JTIK_LANES) {
    const long long own = count - k < JTIK_LANES ? count - k : JTIK_LANES; /* further lanes have the last one, too */
    for (int i = 0; i < JTIK_LANES; ++i) {
      const double* matrix = matrices + 16 * (k + (i < own ? i : own - 1));
      for (int j = 0; j < 16; ++j) entries[j][i] = matrix[j];
    }
    JTIK_NAME_poses(entries, target, valid);
    wrong |= ~(valid[0] != 0.0);
    for (int i = 0; i < own; ++i) {
      for (int j = 0; j < JTIK_NT; ++j) targets[(k + i) * JTIK_NT + j] = target[j][i];
    }
  }
  return !any(wrong);
}
"""


def source(reader: Function | None) -> str:
    """The C code, which follows that of `jtik.symbolic.lanes.maths` in double precision; empty where there is none.

    Args:
        reader: the function of `jtik.Task.matrix_reader`.
    """
    if reader is None or not has_lanes(reader):
        return ""
    return lane_source(reader, "JTIK_NAME_poses", ()) + _SOURCE
