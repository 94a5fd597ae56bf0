"""What strategies of damped least squares share: the step for a given damping."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass

from jtik.strategy import LocalModel, State, StepLimit, TaskDisplacement
from jtik.symbolic import MX, Expression, either, function, is_symbolic, symbol
from jtik.symbolic.factorization import RowVector, damped_multipliers
from jtik_formulations.strategies._parts.scaled_step import ScaledComposition


@dataclass(frozen=True, kw_only=True)
class DampedLeastSquares(ScaledComposition):
    """dq = -J' (J J' + mu I)^-1 r - beta (I - J+ J) grad H. A subclass defines mu.

    Attributes:
        q_limit: limit of Q, the norm of the rotational part of a step [rad]; math.inf for none.
        backtracking: halve the step until V falls. Without it every step is taken.
        secondary: the null-space term.
    """

    q_limit: StepLimit = 1.5

    @abstractmethod
    def damping_of(self, model: LocalModel) -> Expression:
        """mu, in the unit of J J'."""

    def full_step(self, model: LocalModel, state: State) -> TaskDisplacement:
        """-J' (J J' + mu I)^-1 r."""
        return damped_step(model, self.damping_of(model) + model.curvature)


def damped_where_stagnant(
    model: LocalModel, J: Expression, r: Expression, shortest: RowVector
) -> tuple[Expression, Expression]:
    """J^+ r (n, 1), or J' (J J' + mu I)^-1 r in a step without a time whose error has stopped falling; and its image.

    The second one is evaluated only where it is used (motion.md, Q8).

    Args:
        model: the local model.
        J: the matrix (m, n).
        r: right-hand side (m, 1).
        shortest: J^+ r.
    """
    damping, undamped = model.stagnation_damping, (shortest.vector, shortest.image)
    if not is_symbolic(damping):
        return undamped
    given = [symbol(f"a{i}", *each.shape) for i, each in enumerate((J, r, damping, *undamped))]
    rows, right, mu, *known = given
    dq = rows.T @ damped_multipliers(rows, mu, right)
    found = either(function("damped", given, [dq, rows @ dq]), function("undamped", given, known))
    inputs = [MX.sym(f"a{i}", *found.size_in(i)) for i in range(found.n_in())]
    called = function("damped_where_stagnant", inputs, found(*inputs), inline=False)
    vector, image = called(damping > 0, J, r, damping, *undamped)
    return vector, image


def damped_step(model: LocalModel, damping: Expression) -> TaskDisplacement:
    """-J' (J J' + mu I)^-1 r for a mu in the unit of J J'."""
    J = model.J_free
    return TaskDisplacement(J.T @ damped_multipliers(J, damping, -model.here.residual))
