"""Tracing of a criterion: its symbolic value H, and error messages for what CasADi cannot trace."""

from __future__ import annotations

import re
import traceback
import warnings
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from jtik.errors import JtikError
from jtik.symbolic import SX, Expression, is_symbolic, no_silent_float, smooth_numpy_norm, symvar, vec, vertcat

_LIBRARIES = ("casadi", "numpy", "scipy", "jtik/symbolic", "jtik/robot/row_indexing")
"""Parts of file names whose lines an error message does not show: the user's own line is wanted."""

_SVD = "(from jtik.symbolic.svd import SingularValues)"
_ROWS = "(from jtik.symbolic.factorization import RowSpace)"
_LINEAR = (
    "casadi.solve(A, b); solve_ldl(A, b) for a symmetric positive definite A (from jtik.symbolic import solve_ldl)"
)
_EIGENVALUES = f"SingularValues(J).squared, the eigenvalues of J J' {_SVD}"
_LEAST_SQUARES = f"RowSpace(A).least_squares(b).vector {_ROWS}"

_GENERAL = (
    "Use operations that accept expressions, such as numpy.sin, casadi.norm_2, casadi.fmax and casadi.if_else, "
    "in place of math functions and of comparisons in `if`"
)
_OBJECTS = (
    "Make matrices of expressions with stack(rows) (from jtik.symbolic import stack); "
    "numpy.array makes an array of objects, which numpy.linalg does not accept"
)

REPLACEMENTS = {
    "svd": f"SingularValues(J).values {_SVD}",
    "svdvals": f"SingularValues(J).values {_SVD}",
    "eigvalsh": _EIGENVALUES,
    "eigh": _EIGENVALUES,
    "eigvals": _EIGENVALUES,
    "eig": _EIGENVALUES,
    "cond": f"the first of SingularValues(J).values divided by the last {_SVD}",
    "matrix_rank": f"RowSpace(J).rank {_ROWS}",
    "lstsq": _LEAST_SQUARES,
    "pinv": _LEAST_SQUARES,
    "inv": _LINEAR,
    "solve": _LINEAR,
    "norm": "norm(v) (from jtik.symbolic import norm)",
    "det": f"casadi.det(A), or RowSpace(J).volume, which is sqrt(det J J') {_ROWS}",
    "slogdet": f"casadi.log(casadi.det(A)), or the logarithm of RowSpace(J).volume, which is sqrt(det J J') {_ROWS}",
    "einsum": "the operators @ and * of expressions",
    "sort": "casadi.fmin and casadi.fmax",
    "argmin": "casadi.mmin for the smallest entry",
    "argmax": "casadi.mmax for the largest entry",
}
"""NumPy functions that may fail on expressions, by name, and what to use in their place."""


class CriterionError(JtikError):
    """A criterion that cannot be used: not scalar, not traceable, or made of foreign symbols.

    Attributes:
        criterion: name of the criterion.
        reason: what is wrong, and what to do about it.
    """

    def __init__(self, criterion: str, reason: str) -> None:
        super().__init__(criterion, reason)
        self.criterion = criterion
        self.reason = reason

    def __str__(self) -> str:
        return f"criterion {self.criterion!r}: {self.reason}"


def traced(name: str, call: Callable[[], Any], symbols: Iterable[Expression], *, residual: bool = False) -> Expression:
    """The scalar expression that ``call`` returns, or with ``residual`` the column of expressions.

    Args:
        name: name of the criterion, for the error message.
        call: evaluates the criterion on symbols.
        symbols: the expressions whose symbols H may depend on.
        residual: whether ``call`` returns the vector r of H = 1/2 |r|^2.

    Raises:
        CriterionError: when an operation cannot be traced, H is not scalar, or H depends on other symbols.
    """
    H = _called(name, (lambda: as_column(name, call())) if residual else (lambda: _scalar(name, call())))
    known = {symbol.element_hash() for expression in symbols for symbol in symvar(expression)}
    foreign = [str(symbol) for symbol in symvar(H) if symbol.element_hash() not in known]
    if foreign:
        raise CriterionError(name, f"depends on symbols that are not its own: {', '.join(foreign)}")
    return H


def traced_gradient(
    name: str, call: Callable[[], Any], symbols: Sequence[Expression], nq: int
) -> tuple[Expression, Expression] | None:
    """H and dH/dq (nq, 1) that ``call`` returns; None where it returns None.

    Args:
        name: name of the criterion, for the error message.
        call: evaluates `jtik.Criterion.value_and_gradient` on symbols.
        symbols: the expressions whose symbols both may depend on.
        nq: number of entries of q.

    Raises:
        CriterionError: as from `traced`, or for anything else than both.
    """
    found = _called(name, call)
    if found is None:
        return None
    if not isinstance(found, tuple | list) or len(found) != 2:
        raise CriterionError(name, f"value_and_gradient must return H and its gradient, or None, not {short(found)}")
    H, dH = traced(name, lambda: found[0], symbols), traced(name, lambda: found[1], symbols, residual=True)
    if dH.shape != (nq, 1):
        raise CriterionError(name, f"value_and_gradient must return a gradient of {nq} entries, not {dH.shape[0]}")
    return H, dH


def _called(name: str, call: Callable[[], Any]) -> Any:
    """What ``call`` returns. An error of a foreign library becomes a CriterionError with the user's line."""
    try:
        with warnings.catch_warnings():
            # numpy.sin(q) is accepted here; CasADi's notice about numpy functions would repeat at every use
            warnings.filterwarnings("ignore", r"\s*casadi: a numpy function", FutureWarning)
            with no_silent_float(), smooth_numpy_norm():
                return call()
    except JtikError:
        raise
    except Exception as error:
        frames = traceback.extract_tb(error.__traceback__)
        own = [frame for frame in frames if not any(library in frame.filename for library in _LIBRARIES)]
        line = (own or frames)[-1]
        reason = (str(error).strip() or type(error).__name__).splitlines()[0].rstrip(".")
        raise CriterionError(
            name,
            f"CasADi cannot trace the operation `{line.line}` (line {line.lineno} of {line.filename}): {reason}. "
            f"{_advice(line.line or '', reason)}",
        ) from error


def _advice(line: str, reason: str) -> str:
    """What to use in place of the NumPy functions that the reason, or else the line, names."""
    general = _OBJECTS if "ufunc" in reason else _GENERAL
    for text, rest in ((reason, ""), (line, f". {general}")):
        found = [name for name in REPLACEMENTS if re.search(rf"\b(np|numpy|linalg)\.{name}\b", text)]
        if found:
            return "; ".join(f"In place of NumPy's {name} use {REPLACEMENTS[name]}" for name in found) + rest
    return general


def _scalar(name: str, H: Any) -> Expression:
    """H as an expression of shape (1, 1). Raises CriterionError for anything else."""
    several = H.shape != (1, 1) if is_symbolic(H) else isinstance(H, list | tuple) or np.size(H) > 1
    if several:
        shape = H.shape if hasattr(H, "shape") else f"({len(H)},)"
        raise CriterionError(
            name,
            f"must return a scalar, not shape {shape}; sum it, take its norm, or declare that the criterion is "
            "1/2 |r|^2 of what it returns with @jtik.criterion(residual=True)",
        )
    return _entry(name, H, "one scalar expression")


def as_column(name: str, r: Any) -> Expression:
    """A residual as a column of expressions (k, 1).

    Args:
        name: name of the criterion, for the error message.
        r: a column or a row of expressions or numbers, a list of scalars, or one scalar.

    Raises:
        CriterionError: for anything else.
    """
    accepted = "a vector of expressions, one for each residual"
    if not is_symbolic(r):
        single = isinstance(r, str | bytes) or (not isinstance(r, list | tuple) and np.ndim(r) == 0)
        r = vertcat(*[_entry(name, each, accepted) for each in ([r] if single else r)])
    if 1 not in r.shape or 0 in r.shape:
        raise CriterionError(name, f"must return {accepted}, not shape {r.shape}; make a matrix one by casadi.vec")
    return vec(r)


def _entry(name: str, value: Any, accepted: str) -> Expression:
    """One scalar as an expression (1, 1)."""
    if is_symbolic(value) and value.shape == (1, 1):
        return value
    if not is_symbolic(value):
        number = np.asarray(value)
        if number.dtype.kind in "fiu" and number.size == 1:
            return SX(float(number.item()))
    raise CriterionError(name, f"must return {accepted}, not {short(value)}")


def short(value: Any) -> str:
    """The type of a value, and the value where its text is short."""
    text, kind = repr(value), type(value).__name__
    return kind if value is None or len(text) > 30 or "\n" in text else f"{kind} {text}"
