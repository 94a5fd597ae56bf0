"""When a direction in the null space is larger than the error of its own computation."""

from __future__ import annotations

from jtik.symbolic import Expression, fmax, norm

NOISE = 1e-13
"""|h| / |grad H| below which h = (I - J+ J) grad H is rounding, not a direction."""

LEAKAGE = 1e-10
"""Largest |J nu| / |J|, relative to the longer one of nu and the task displacement."""


def significant(length: Expression, gradient_norm: Expression) -> Expression:
    """1 where ``length`` = |h| is above the rounding of a gradient with this norm, else 0."""
    return length > NOISE * gradient_norm


def in_null_space(basis: Expression, dq: Expression, task_dq: Expression, *, shortest: float = 0.0) -> Expression:
    """1 where ``dq`` (n, 1) is in the null space up to `LEAKAGE`, else 0: it is then shorter than its own error.

    Args:
        basis: orthonormal rows of the row space of J (m, n).
        dq: displacement (n, 1).
        task_dq: the task displacement (n, 1) to which it is added.
        shortest: length to which the leakage is relative where both displacements are shorter.
    """
    return norm(basis @ dq) <= LEAKAGE * fmax(fmax(norm(dq), norm(task_dq)), shortest)
