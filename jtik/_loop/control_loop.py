"""What a control loop calls beside `InverseKinematics.step`: before it begins, and after a jump."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from numpy.typing import ArrayLike

from jtik._loop.engine import Engine
from jtik.progress import Progress
from jtik.result.jog import Jog
from jtik.result.report import Report

Direction = str | int | ArrayLike | None
Velocity = Mapping[str, ArrayLike] | ArrayLike | None


class ControlLoop:
    """Base of a solver that a control loop uses."""

    _engine: Engine

    def warm_up(self, *, progress: Progress = False) -> None:
        """Build now what is otherwise built when it is first needed, so that no call of a control loop waits for it.

        ``step(dt=)`` and `track` have a function of their own, which takes about as long to build as the solver. The
        escape from saddle points is built when a solve first stalls: some milliseconds for an arm, some tenths of a
        second for a humanoid. The same holds, with a criterion, for the test whether a pose at rest is a minimum of it.
        A strategy that accepts every step, such as ``Damped(backtracking=False)`` without a
        criterion, also has a function of its own for a `step` without a time. Call it once, at any time: it changes no
        result.

        Args:
            progress: as in the constructor.

        Raises:
            ArgumentError: for a progress that is not a bool or a function.
            MissingExtraError: for a bar without rich.
        """
        self._engine.warm_up(progress)

    def reset(self, *, velocity: Velocity = None) -> None:
        """Forget the state that `step` and `jog` keep, as after a jump of the target, or before this solver takes over.

        Args:
            velocity: velocities of the joints from which limits of acceleration count in the next step with a ``dt``
                [rad/s] or [m/s]: numbers (n,), or a dict from joint name to velocity, 0 for the others. None for rest.

        Raises:
            ArgumentError: for a velocity of another shape, or one that is not finite.
            UnknownNameError: when a dict names a joint that does not exist.
        """
        read = self._engine.problem.robot.velocity_values
        given = None if velocity is None else read(velocity, default=0.0, argument="velocity")
        self._engine.stepping.reset()
        self._engine.jogging.reset()
        if given is not None:
            self._engine.stepping.moves(given)

    def jog(self, q: ArrayLike, rate: float, *, direction: Direction = None, dt: float = 0.02) -> Jog:
        """One displacement along the self-motion: the arm moves, and what its tasks measure stays as it is at ``q``.

        For an operator's slider or joystick axis, one call each period: pass the ``q`` of the last call. Limits of
        position, velocity and acceleration hold as in ``step(dt=)``, and so do clearances. It works for every strategy.
        A task that does not say which target ``q`` meets, such as `LookAtTask`, keeps its error to the last target of
        a `step` or a solve. The first call builds its functions, some tenths of a second for an arm.

        At the end of the self-motion q stays and ``ended`` is True; with the opposite sign it comes back.

        Args:
            q: configuration, (nq,).
            rate: speed along the self-motion [rad/s], of the vector of all joint speeds; 1 m counts as 1 rad. One call
                moves by at most 0.1 rad.
            direction: of a positive rate. A joint's name: as this joint increases. A criterion's name, or "descent" for
                all criteria: as it decreases. A vector (n,): its part in the null space. An index from 0: one of a
                basis that is carried on from call to call, so that it does not jump; `reset` begins another one. None
                is 0: with one degree of redundancy the only one.
            dt: duration of the step [s].

        Raises:
            ArgumentError: for a wrong shape, NaN or infinity, or a direction of another form, naming it.
        """
        return self._engine.jogging.jog(q, rate, direction, dt)

    def report(self, q: ArrayLike, target: Any) -> Report:
        """Task, criteria and active limits at a configuration, as numbers, without a step.

        Args:
            q: configuration, (nq,).
            target: the target, as in `step`.

        Raises:
            ArgumentError: for an argument of wrong shape, NaN or infinity, naming it.
        """
        return self._engine.report(q, target)
