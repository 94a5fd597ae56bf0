"""What a control loop calls beside `InverseKinematics.step`: before it begins, and after a jump."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from jtik._loop.engine import Engine
from jtik.result.report import Report


class ControlLoop:
    """Base of a solver that a control loop uses."""

    _engine: Engine

    def warm_up(self) -> None:
        """Build now what is otherwise built when it is first needed, so that no call of a control loop waits for it.

        ``step(dt=)`` and `track` have a function of their own, which takes about as long to build as the solver. The
        escape from saddle points is built when a solve first stalls: some milliseconds for an arm, some tenths of a
        second for a humanoid. The same holds, with a criterion, for the test whether a pose at rest is a minimum of it.
        A strategy that accepts every step, such as ``Damped(backtracking=False)`` without a
        criterion, also has a function of its own for a `step` without a time. Call it once, at any time: it changes no
        result.
        """
        self._engine.warm_up()

    def reset(self) -> None:
        """Forget the state that `step` keeps, as after a jump of the target; the robot is then at rest."""
        self._engine.stepping.reset()

    def report(self, q: ArrayLike, target: Any) -> Report:
        """Task, criteria and active limits at a configuration, as numbers, without a step.

        Args:
            q: configuration, (nq,).
            target: the target, as in `step`.

        Raises:
            ArgumentError: for an argument of wrong shape, NaN or infinity, naming it.
        """
        return self._engine.report(q, target)
