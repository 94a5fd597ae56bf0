"""Quadratic programs with many rows: those that are a matrix of the local model are passed to the solver as it is.

Entry by entry they would be most of a step's operations, and of the time that it takes to build and to compile it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from jtik.qp.quadratic_program import QuadraticProgram
from jtik.symbolic import MX, Expression, Function, function, is_equal, vertcat, zeros
from jtik.symbolic.stacked_rows import stacked


@dataclass(frozen=True)
class PassedRows:
    """Which rows of a program's matrix C are matrices that a function is given.

    Attributes:
        groups: for each group of rows the number of its rows, and the input that is its matrix; None for another one.
    """

    groups: tuple[tuple[int, int | None], ...]

    @classmethod
    def of(cls, qp: QuadraticProgram, known: Sequence[Expression]) -> PassedRows | None:
        """Those of a program that is written in the symbols ``known``; None for one with few rows.

        Args:
            qp: the quadratic program.
            known: the inputs of the function, from the first.
        """
        if not qp.has_many_rows:
            return None
        return cls(tuple((group.count, _index(group.matrix, known)) for group in qp.rows))

    def left(self, qp: QuadraticProgram) -> list[Expression]:
        """The data of the program without the rows that are passed, and its penalties."""
        P, q, _, *bounds = qp.data()
        others = [group.matrix for group, (_, at) in zip(qp.rows, self.groups, strict=True) if at is None]
        return [P, q, vertcat(*others) if others else zeros(0, qp.size), *bounds, *qp.penalties]

    def whole(self, left: Function) -> Function:
        """(the same inputs) -> all data of the program.

        Args:
            left: (inputs) -> what `left` returns.
        """
        inputs = [MX.sym(f"i{i}", *left.size_in(i)) for i in range(left.n_in())]
        P, q, others, *bounds = left.call(inputs)
        rows, start = [], 0
        for count, at in self.groups:
            rows.append(others[start : start + count, :] if at is None else inputs[at])
            start += count if at is None else 0
        return function(left.name(), inputs, [P, q, stacked(*rows), *bounds], cse=False)


def _index(matrix: Expression, known: Sequence[Expression]) -> int | None:
    """Which of the symbols a matrix is; None for none of them."""
    for at, each in enumerate(known):
        if each.shape == matrix.shape and is_equal(each, matrix):
            return at
    return None
