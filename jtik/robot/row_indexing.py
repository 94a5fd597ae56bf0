"""CasADi matrices that a single index reads by rows, as NumPy does.

CasADi reads ``J[:3]`` of a matrix as its first three numbers, column by column. A criterion is written once for
numbers and for expressions, so both must mean the same: the first three rows.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from jtik.errors import ArgumentError
from jtik.symbolic import MX, SX, Expression


class _RowIndexing:
    """Reads ``A[:3]``, ``A[0]`` and ``A[[0, 2]]`` as rows; ``A[i, j]`` and all operations are CasADi's own."""

    def __getitem__(self, index: Any) -> Expression:
        everything = slice(None)
        if isinstance(index, tuple) and len(index) == 2:
            found = super().__getitem__(index)  # type: ignore[misc]
            return found if any(_is_integer(each) for each in index) else by_rows(found)
        if _is_integer(index):
            return super().__getitem__((int(index), everything))  # type: ignore[misc]
        if isinstance(index, slice):
            return by_rows(super().__getitem__((index, everything)))  # type: ignore[misc]
        rows = _integers(index)
        if rows is None:
            accepted = "rows such as J[:3], J[0] or J[[0, 2]], or rows and columns such as J[:3, 0]"
            raise ArgumentError("index", index, accepted)
        return by_rows(super().__getitem__((rows, everything)))  # type: ignore[misc]

    @property
    def T(self) -> Expression:
        """The transpose, which is read by rows, too."""
        return by_rows(super().T)  # type: ignore[misc]

    def __array_function__(self, func: Any, types: Any, args: Any, kwargs: Any) -> Any:
        casadi_matrix = _as_casadi(self)  # CasADi implements NumPy functions for its own types only
        return casadi_matrix.__array_function__(
            func, (type(casadi_matrix),), [_as_casadi(each) for each in args], kwargs
        )


class RowIndexedSX(_RowIndexing, SX):  # type: ignore[misc]
    """A ``casadi.SX`` that a single index reads by rows."""


class RowIndexedMX(_RowIndexing, MX):  # type: ignore[misc]
    """A ``casadi.MX`` that a single index reads by rows."""


def _as_casadi(value: Any) -> Any:
    """CasADi's own type for a matrix read by rows, also inside a list; anything else as it is."""
    if isinstance(value, RowIndexedSX):
        return SX(value)
    if isinstance(value, RowIndexedMX):
        return MX(value)
    return type(value)(map(_as_casadi, value)) if type(value) in (list, tuple) else value


def by_rows(matrix: Expression) -> Expression:
    """The same expression, read by rows where it is indexed by a single index. Results of operations are not."""
    return RowIndexedSX(matrix) if isinstance(matrix, SX) else RowIndexedMX(matrix)


def _is_integer(index: Any) -> bool:
    return isinstance(index, (int, np.integer)) and not isinstance(index, bool)


def _integers(index: Any) -> list[int] | None:
    """The row numbers of a list, range or array of integers; None for anything else."""
    if not isinstance(index, (Sequence, np.ndarray)) or isinstance(index, (str, tuple)):
        return None
    rows = np.asarray(index)
    return rows.tolist() if rows.ndim == 1 and rows.dtype.kind == "i" else None
