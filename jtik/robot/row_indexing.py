"""CasADi matrices that a single index reads by rows, as NumPy does.

CasADi reads ``J[:3]`` of a matrix as its first three numbers, column by column. A criterion is written once for
numbers and for expressions, so both must mean the same: the first three rows. Operators and NumPy's functions give such
matrices, too; CasADi's own functions, such as ``casadi.mtimes``, give plain ones, whose rows are ``A[:3, :]``.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from jtik.errors import ArgumentError
from jtik.symbolic import MX, SX, Expression, reshape

_OPERATORS = [
    f"__{prefix}{name}__"
    for name in ("add", "sub", "mul", "truediv", "floordiv", "mod", "pow", "matmul")
    for prefix in ("", "r", "i")
] + ["__neg__", "__pos__", "__abs__"]


class _RowIndexing:
    """Reads ``A[:3]``, ``A[0]`` and ``A[[0, 2]]`` as rows; ``A[i, j]`` and all numbers are CasADi's own."""

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
        matrix = _as_casadi(self)  # CasADi implements NumPy functions for its own types only
        given = {name: _as_casadi(each) for name, each in kwargs.items()}
        found = matrix.__array_function__(func, (type(matrix),), [_as_casadi(each) for each in args], given)
        return _again_by_rows(self, found)

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **kwargs: Any) -> Any:
        matrix = _as_casadi(self)
        return _again_by_rows(self, matrix.__array_ufunc__(ufunc, method, *map(_as_casadi, inputs), **kwargs))

    def reshape(self, shape: tuple[int, int]) -> Expression:
        """The matrix of this shape with the same numbers, row by row as in NumPy."""
        rows, columns = shape
        return by_rows(reshape(_as_casadi(self).T, columns, rows).T)


def _operator(name: str) -> Callable[..., Any]:
    """CasADi's operator, whose result is read by rows."""

    def operator(self: Any, *others: Any) -> Any:
        found = getattr(super(_RowIndexing, self), name)(*others)
        return found if found is NotImplemented else _again_by_rows(self, found)

    operator.__name__ = name
    return operator


for _name in _OPERATORS:
    setattr(_RowIndexing, _name, _operator(_name))


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


def _again_by_rows(operand: Expression, found: Any) -> Any:
    """What an operation on ``operand`` found, read by rows where it is a matrix; columns and scalars as they are.

    A single row is read by rows only if it has the shape of the operand: ``v.T @ J`` is a vector of NumPy's.
    """
    if isinstance(found, (tuple, list)):
        return type(found)(_again_by_rows(operand, each) for each in found)
    matrix = isinstance(found, (SX, MX)) and (min(found.shape) > 1 or found.shape == operand.shape != (1, 1))
    return by_rows(found) if matrix else found


def by_rows(matrix: Expression) -> Expression:
    """The same expression, read by rows where it is indexed by a single index."""
    return RowIndexedSX(matrix) if isinstance(matrix, SX) else RowIndexedMX(matrix)


def _is_integer(index: Any) -> bool:
    return isinstance(index, (int, np.integer)) and not isinstance(index, bool)


def _integers(index: Any) -> list[int] | None:
    """The row numbers of a list, range or array of integers; None for anything else."""
    if not isinstance(index, (Sequence, np.ndarray)) or isinstance(index, (str, tuple)):
        return None
    rows = np.asarray(index)
    return rows.tolist() if rows.ndim == 1 and rows.dtype.kind == "i" else None
