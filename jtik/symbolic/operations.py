"""CasADi's expression types and operations, under typed names, and small operations built on them.

Every use of CasADi in jtik goes through this module. CasADi has no type annotations, so each name is annotated here as
``Any`` once. All helpers can be differentiated: a branch that is not taken produces no NaN.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, TypeAlias

import casadi
import numpy as np
from numpy.typing import NDArray

Expression: TypeAlias = Any
"""A CasADi expression (``casadi.SX`` or ``casadi.MX``), scalar or matrix."""

Function: TypeAlias = Any
"""A ``casadi.Function``."""

# Types of expressions: SX of scalars, which the step is made of, and MX of matrices and calls.
SX: Any = casadi.SX
MX: Any = casadi.MX

# Elementwise functions.
cos: Any = casadi.cos
sin: Any = casadi.sin
atan2: Any = casadi.atan2
sqrt: Any = casadi.sqrt
log: Any = casadi.log
exp: Any = casadi.exp
fabs: Any = casadi.fabs
floor: Any = casadi.floor
fmax: Any = casadi.fmax
fmin: Any = casadi.fmin

# Conditions: numbers 0 and 1. Both branches of if_else are evaluated.
if_else: Any = casadi.if_else
logic_and: Any = casadi.logic_and
logic_or: Any = casadi.logic_or
logic_not: Any = casadi.logic_not

# Vectors and matrices.
vertcat: Any = casadi.vertcat
horzcat: Any = casadi.horzcat
reshape: Any = casadi.reshape
repmat: Any = casadi.repmat
vec: Any = casadi.vec
densify: Any = casadi.densify
diag: Any = casadi.diag
trace: Any = casadi.trace
tril: Any = casadi.tril
skew: Any = casadi.skew
dot: Any = casadi.dot
cross: Any = casadi.cross
SIDE_BY_SIDE = 32
"""Sums that a long column of a matrix expression is summed in first: one after another its numbers take longer."""


def sum1(x: Any) -> Any:
    """Sum of each column (1, n).

    Args:
        x: matrix (k, n), an expression or numbers.
    """
    count = x.shape[0] // SIDE_BY_SIDE
    if not isinstance(x, casadi.MX) or x.shape[1] != 1 or count < 4 or not x.is_dense():
        return casadi.sum1(x)
    end = count * SIDE_BY_SIDE
    sums = casadi.reshape(x[:end], SIDE_BY_SIDE, count) @ casadi.MX.ones(count, 1)
    return casadi.sum1(casadi.vertcat(sums, x[end:]))


sum2: Any = casadi.sum2
sumsqr: Any = casadi.sumsqr
norm_inf: Any = casadi.norm_inf
mmax: Any = casadi.mmax
mmin: Any = casadi.mmin

# Derivatives, and what an expression is made of.
jacobian: Any = casadi.jacobian
gradient: Any = casadi.gradient
symvar: Any = casadi.symvar
substitute: Any = casadi.substitute
is_equal: Any = casadi.is_equal

# A function that Python evaluates, and the shapes of its arguments and results.
Callback: Any = casadi.Callback
Sparsity: Any = casadi.Sparsity

# Functions from elsewhere, and the instructions of a function.
external: Any = casadi.external
has_conic: Any = casadi.has_conic
OP_CALL: int = casadi.OP_CALL
OP_INPUT: int = casadi.OP_INPUT
OP_OUTPUT: int = casadi.OP_OUTPUT
OP_CONST: int = casadi.OP_CONST

LARGEST = 1.7e308
"""Just below the largest double: NaN and infinity compare false with ``<= LARGEST``."""

TINY = 1e-300
"""Added under a square root or to a denominator that may be zero; below every value that matters."""


def symbol(name: str, rows: int, columns: int = 1) -> Expression:
    """A matrix of free symbols, shape (``rows``, ``columns``), that are called ``name``."""
    return SX.sym(name, rows, columns)


def zeros(rows: int, columns: int = 1) -> Expression:
    """A dense matrix of zeros, shape (``rows``, ``columns``)."""
    return SX.zeros(rows, columns)


def identity(size: int) -> Expression:
    """The identity matrix, shape (``size``, ``size``)."""
    return SX.eye(size)


def gram(matrix: Expression, weights: Expression | None = None) -> Expression:
    """The Gram matrix M' diag(weights) M, (n, n), each entry computed once.

    Args:
        matrix: M (m, n).
        weights: one for each row (m, 1); all are 1 when None.
    """
    weighted = matrix if weights is None else repmat(weights, 1, matrix.shape[1]) * matrix
    return casadi.densify(casadi.triu2symm(casadi.triu(casadi.mtimes(weighted.T, matrix))))


def hessian(scalar: Expression, variables: Expression) -> Expression:
    """Second derivatives (n, n) of a ``scalar`` with respect to ``variables`` (n, 1)."""
    return casadi.hessian(scalar, variables)[0]


def numbers(matrix: Expression) -> NDArray[np.float64] | None:
    """The entries of a ``matrix`` without symbols, (rows, columns); None where there are any."""
    if isinstance(matrix, casadi.MX) or not SX(matrix).is_constant():
        return None
    return np.array(casadi.DM(SX(matrix)).full())


def conic(name: str, plugin: str, n: int, rows: int, options: Mapping[str, Any]) -> Function:
    """(P, q, C, l, u, lb, ub) -> (x, row multipliers, box multipliers) by a conic plugin, for dense data.

    Args:
        name: name of the function.
        plugin: name of CasADi's plugin.
        n: number of variables.
        rows: number of rows of C.
        options: options of the plugin.
    """
    shapes = {"h": casadi.Sparsity.dense(n, n), "a": casadi.Sparsity.dense(rows, n)}
    solver = casadi.conic(name, plugin, shapes, dict(options))
    sizes = ((n, n), (n, 1), (rows, n), (rows, 1), (rows, 1), (n, 1), (n, 1))
    data = [MX.sym(f"d{i}", *size) for i, size in enumerate(sizes)]
    P, q, C, low, high, lower, upper = data
    result = solver(h=P, g=q, a=C, lba=low, uba=high, lbx=lower, ubx=upper)
    return casadi.Function(name, data, [result["x"], result["lam_a"], result["lam_x"]])


def either(when: Function, otherwise: Function) -> Function:
    """A function of a condition and arguments that evaluates one of two functions.

    Args:
        when: the function where the condition is not 0.
        otherwise: the function where it is 0, of the same arguments and results.
    """
    return casadi.Function.if_else("either", when, otherwise)


def once_for_each(build: Callable[[Expression], Expression]) -> Callable[[Expression], Expression]:
    """The same function, which returns the same expression when it is called with the same one again.

    An expression that is built twice makes a graph larger, and the elimination of what is there twice takes most of the
    time of building a function.

    Args:
        build: function of one expression.
    """
    built = list[tuple[Expression, Expression]]()

    def found(argument: Expression) -> Expression:
        for known, result in built:
            if known.shape == argument.shape and is_equal(known, argument):
                return result
        result = build(argument)
        built.append((argument, result))
        return result

    return found


def is_symbolic(value: object) -> bool:
    """Whether ``value`` is a CasADi expression rather than numbers."""
    return isinstance(value, (casadi.SX, casadi.MX))


def function(
    name: str,
    inputs: Sequence[Expression],
    outputs: Sequence[Expression],
    input_names: Sequence[str] = (),
    output_names: Sequence[str] = (),
    *,
    cse: bool = True,
    inline: bool = True,
) -> Function:
    """A ``casadi.Function`` with dense outputs.

    Args:
        name: name of the function.
        inputs: symbols of the inputs.
        outputs: expressions of the outputs.
        input_names: names of the inputs; CasADi's by default.
        output_names: names of the outputs; give both or neither.
        cse: whether common subexpressions are eliminated. It takes most of the time of building a large function, and
            makes each call faster by a tenth or less where the expression was written once.
        inline: whether an expression that the function is applied to is a copy of its outputs rather than a call.
    """
    dense = [casadi.densify(output) for output in outputs]
    names = [list(input_names), list(output_names)] if input_names else []
    return casadi.Function(name, list(inputs), dense, *names, {"cse": cse, "never_inline": not inline})


def norm(vector: Expression) -> Expression:
    """Euclidean norm of a ``vector``, whose derivative is zero, not NaN, at the zero vector."""
    return sqrt(sumsqr(vector) + TINY)


def without_derivative(share: Expression) -> Expression:
    """A ``share`` in [0, 1], rounded to 1e-9, whose derivative is zero: for what a minimum does not depend on."""
    return floor(share * 2**30) * 2.0**-30


def ratio(numerator: Expression, denominator: Expression) -> Expression:
    """``numerator / denominator`` for a non-negative denominator: 0 / 0 is 0."""
    return numerator / (denominator + TINY)


def is_finite(value: Expression) -> Expression:
    """1 where every entry of ``value`` is finite, else 0."""
    if isinstance(value, casadi.MX):  # loops, of which those along the rows are vectors
        return fabs(sum1(sum2(value) if value.shape[1] > 1 else value)) <= LARGEST
    return fabs(sum1(casadi.vec(value))) <= LARGEST


def stack(rows: Sequence[Sequence[Expression | float]]) -> Expression:
    """A matrix from its ``rows`` of scalars."""
    return vertcat(*[horzcat(*row) for row in rows])


@contextmanager
def no_silent_float() -> Iterator[None]:
    """Within it ``float`` of an expression with symbols raises TypeError; CasADi itself gives NaN silently."""
    original = SX.__float__

    def guarded(expression: Expression) -> float:
        if not expression.is_constant():
            raise TypeError("a number is needed, and the value is an expression")
        return float(original(expression))

    SX.__float__ = guarded
    try:
        yield
    finally:
        SX.__float__ = original


def _is_norm_of_row(x: Any, ord: Any = None, *_: Any, **__: Any) -> bool:
    """Whether these arguments of ``numpy.linalg.norm`` are a row (1, n) and an order other than the Euclidean one."""
    return isinstance(x, SX) and x.shape[0] == 1 < x.shape[1] and ord not in (None, 2, "fro")


@contextmanager
def smooth_numpy_norm() -> Iterator[None]:
    """Within it ``numpy.linalg.norm(x)`` of an expression is `norm`: its derivative at zero is zero, not NaN.

    What CasADi would answer otherwise than NumPy raises TypeError: the norm of order 1 or infinity of a row, which
    CasADi takes for a matrix, and ``numpy.any`` and ``numpy.all``.
    """
    original = getattr(SX, "__array_function__", None)  # CasADi has it since 3.7
    if original is None:
        yield
        return

    def dispatched(expression: Expression, func: Any, types: Any, args: Any, kwargs: Any) -> Any:
        if func is np.linalg.norm and len(args) == 1 and not kwargs and isinstance(args[0], SX):
            return norm(args[0])
        if func is np.linalg.norm and _is_norm_of_row(*args, **kwargs):
            raise TypeError("numpy.linalg.norm with an order takes a row (1, n) for a matrix: give it the column x.T")
        if func in (np.any, np.all):
            raise TypeError(f"numpy.{func.__name__} has no symbolic form: use casadi.fmax or casadi.fmin of conditions")
        return original(expression, func, types, args, kwargs)

    SX.__array_function__ = dispatched
    try:
        yield
    finally:
        SX.__array_function__ = original
