"""Jogging: what `InverseKinematics.jog` runs, a displacement along the self-motion (formulations/null_space_jog.md)."""

from __future__ import annotations

from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np

from jtik._loop.arguments import ConfigurationReader
from jtik._loop.escapes.saddle import SaddleEscape
from jtik._loop.exclusive_use import ExclusiveUse, in_use
from jtik._loop.jog_direction import DirectionReader, Wish
from jtik._loop.runners import Runners
from jtik._step.self_motion import displaced, error_change, null_space, tangent
from jtik._step.symbolic_problem import SymbolicProblem
from jtik.arguments import number
from jtik.constraints.limits import AT_LIMIT
from jtik.result.jog import Jog
from jtik.symbolic.compile import CompiledFunction
from jtik.types import Array

LONGEST = 0.1
"""Longest displacement of one call [rad]."""

SLOWER = 0.05
"""Share of a wish that lies in the null space below which the motion slows down in proportion."""

ENDED = 1e-4
"""The share below which nothing of a wish is left."""

EXACT = 1e-9
"""Change of the error that a call may leave, relative to its length and to max(1, |J|)."""

ROUNDING = 1e-13
"""Change of the error that is rounding, relative to max(1, |J|)."""

HALVINGS = 5
"""How often a displacement is halved where the task, a limit or a clearance does not allow it."""

TIE = 1e-6
"""Relative difference of two projections below which the first joint is taken."""

SAME = 1e-9
"""Relative difference of two lengths that is rounding."""

CURVED = 1e-6
"""Smallest part of a motion in the sense of the wish, relative to its length, that is more than rounding."""

MOVES = "moves along the self-motion"


class _Way(NamedTuple):
    """A direction at q: a unit vector (n,), what is left of the wish, the joints held at limits, the wish at q."""

    z: Array
    share: float
    held: Array
    wish: Array


class _Displacement(NamedTuple):
    """Where a displacement ends.

    Attributes:
        q: its end (nq,).
        length: its signed length along z.
        errors: change of the errors [m] and [rad].
        z: its direction (n,).
        halved: whether a longer one was not possible.
    """

    q: Array
    length: float
    errors: tuple[float, float]
    z: Array
    halved: bool


class Jogging:
    """Displacements along the self-motion; the smooth basis and the last direction are kept from call to call."""

    def __init__(
        self,
        problem: SymbolicProblem,
        runners: Runners,
        configurations: ConfigurationReader,
        *,
        escape: SaddleEscape,
        exclusive: ExclusiveUse,
    ) -> None:
        self._problem, self._robot, self._runners = problem, problem.robot, runners
        self._read, self._clear, self._exclusive = configurations.read, escape.clear, exclusive
        self._directions = DirectionReader(problem)
        joints = {problem.robot.v_slice(joint.name).start: joint.name for joint in problem.robot.independent_joints}
        self._joint_of = joints
        self._change_of_step = np.full(problem.robot.n, np.inf)
        self._basis: Array | None = None
        self._last: _Displacement | None = None

    @cached_property
    def _null_space(self) -> CompiledFunction:
        return CompiledFunction(self._problem.once("null_space", lambda: null_space(self._problem)))

    @cached_property
    def _tangent(self) -> CompiledFunction:
        return CompiledFunction(self._problem.once("tangent", lambda: tangent(self._problem)))

    @cached_property
    def _displaced(self) -> CompiledFunction:
        accelerated = bool((self._runners.acceleration < np.inf).any())
        build = partial(displaced, self._problem, accelerated=accelerated)
        return CompiledFunction(self._problem.once(f"displaced, {accelerated=}", build))

    @cached_property
    def _error_change(self) -> CompiledFunction:
        return CompiledFunction(self._problem.once("error_change", lambda: error_change(self._problem)))

    def reset(self) -> None:
        """Forget the basis and the last direction."""
        self._basis = self._last = None
        if "timed_box" in vars(self._runners):
            self._runners.timed_box[1].rest()

    def jog(self, q: Any, rate: Any, direction: Any, dt: Any) -> Jog:
        """A displacement, as `InverseKinematics.jog` describes it."""
        if self._exclusive.busy:
            raise in_use()
        try:
            self._exclusive.busy = True
            speed, start = number("rate", rate), self._read("q", q)
            wish = self._directions.read(direction)
            _, box = self._runners.timed_box
            box.narrow(start, dt)
            self._change_of_step = self._runners.acceleration * float(dt) ** 2
            return self._moved(start, speed, wish, float(dt))
        finally:
            self._exclusive.busy = False

    def _moved(self, q: Array, rate: float, wish: Wish, dt: float) -> Jog:
        box = self._runners.timed_box[1]
        way, asked = self._way(q, rate, wish), rate * dt
        length = max(-LONGEST, min(LONGEST, asked))
        if wish.column is None:
            length *= min(1.0, way.share / SLOWER)
        found = self._displacement(q, way, length) if way.share > ENDED else None
        if found is None and way.share <= ENDED and not way.held.any():
            found = self._back(q, rate, wish, min(LONGEST, abs(asked)))
        if isinstance(found, _Displacement):
            self._last = found
            box.moved(found.q)
            reason = MOVES
            if abs(found.length - asked) > SAME * abs(asked):
                reason += f", {self._what_limits(found, length, asked)}"
            return Jog(found.q, found.length / dt, *found.errors, False, reason)
        braked = box.braked()
        moving = float(np.abs(self._robot.difference(q, braked)).max()) > AT_LIMIT
        box.moved(braked)
        if moving:
            outside = not self._inside(q)
            reason = "moves into its limits" if outside else "slows down as its limits of acceleration allow"
            errors = self._change(q, braked)
            return Jog(braked, 0.0, *errors, False, f"{reason}, and cannot hold the end effector meanwhile")
        if rate == 0:
            return Jog(q.copy(), 0.0, 0.0, 0.0, False, "at rest: the rate is 0")
        return Jog(q.copy(), 0.0, 0.0, 0.0, True, f"ended: {self._what_ends(wish, way, rate, found)}")

    def _way(self, q: Array, rate: float, wish: Wish) -> _Way:
        """The direction at q; that of a basis is carried on from the last call."""
        vector = wish.vector if wish.column is None else self._carried(q)[:, wish.column]
        return self._tangent_at(q, vector, wish.weights, rate)

    def _tangent_at(self, q: Array, vector: Array, weights: Array, rate: float) -> _Way:
        inputs = self._runners.step_inputs
        limits = inputs.lower, inputs.upper
        z, share, held, here = self._tangent(
            q, inputs.target, inputs.parameters, *limits, vector, weights, np.sign(rate)
        )
        return _Way(z[:, 0], float(share[0, 0]), held[:, 0], here[:, 0])

    def _carried(self, q: Array) -> Array:
        """The smooth basis at q, (n, n): columns of zeros where the null space has fewer dimensions."""
        target = self._runners.step_inputs.target
        before = np.zeros((self._robot.n, self._robot.n)) if self._basis is None else self._basis
        projector, basis = self._null_space(q, target, before)
        if np.count_nonzero(basis.any(axis=0)) != round(float(np.trace(projector))):
            basis = _first_basis(projector)
        self._basis = basis
        return basis

    def _displacement(self, q: Array, way: _Way, length: float) -> _Displacement | str:
        """The displacement along z, as long as task, limits and clearances allow; what prevents it otherwise."""
        box, inputs, why = self._runners.timed_box[1], self._runners.step_inputs, ""
        for _ in range(HALVINGS):
            end, taken, errors, scale = self._displaced(q, *self._bounds(), way.z, way.held, length)
            q_end, length = end[:, 0], float(taken[0, 0])
            if length == 0.0:
                return why
            within = np.isfinite(q_end).all() and errors.max() <= (ROUNDING + EXACT * abs(length)) * max(
                1.0, float(scale[0, 0])
            )
            if not within:
                why = "no self-motion leads further from this singular pose"
            elif box.slowed(q_end) is not q_end:
                why = "a joint is as fast as it may be"
            elif not self._clear(q, np.asarray(self._robot.difference(q, q_end)), inputs):
                why = "a clearance"
            else:
                return _Displacement(q_end.copy(), length, (float(errors[0, 0]), float(errors[1, 0])), way.z, bool(why))
            length /= 2
        return why

    def _back(self, q: Array, rate: float, wish: Wish, length: float) -> _Displacement | str:
        """The way back from the end of a range, where the wish has no first-order part in the null space.

        The opposite of the last motion is tried first, or without one the first direction of the basis.
        """
        if length == 0.0 or wish.column is not None:
            return ""
        first = self._carried(q)[:, 0] if self._last is None else -np.sign(self._last.length) * self._last.z
        for along in (first, -first):
            way = self._tangent_at(q, np.sign(rate) * along, 0 * wish.weights, rate)
            if way.share <= ENDED:
                continue
            found = self._displacement(q, way, np.sign(rate) * length)
            if isinstance(found, str):
                continue
            there = self._tangent_at(found.q, wish.vector, wish.weights, rate).wish
            if there @ self._robot.difference(q, found.q) * np.sign(rate) > CURVED * length * np.linalg.norm(there):
                return found
        return ""

    def _change(self, q: Array, end: Array) -> tuple[float, float]:
        """Change of the errors from q to ``end``."""
        change = self._error_change(q, end, self._runners.step_inputs.target)[0][:, 0]
        return float(change[0]), float(change[1])

    def _inside(self, q: Array) -> bool:
        """Whether q is within the position limits."""
        limits = self._runners.step_inputs
        return bool(((q >= limits.lower - AT_LIMIT) & (q <= limits.upper + AT_LIMIT)).all())

    def _bounds(self) -> tuple[Array, ...]:
        """Target, box of the next q, position limits, and largest change of a step."""
        inputs, limits = self._runners.timed_box[0], self._runners.step_inputs
        return inputs.target, inputs.lower, inputs.upper, limits.lower, limits.upper, self._change_of_step

    def _what_limits(self, found: _Displacement, length: float, asked: float) -> str:
        """Why a displacement is not as long as it was asked for."""
        inputs, limits = self._runners.timed_box[0], self._runners.step_inputs
        for i, j in self._problem.bounded:
            for bound, limit in ((inputs.lower[i], limits.lower[i]), (inputs.upper[i], limits.upper[i])):
                if abs(found.q[i] - bound) <= AT_LIMIT:
                    what = "position" if abs(bound - limit) <= AT_LIMIT else "velocity or acceleration"
                    return f"slower than asked: {what} limit of joint {self._joint_of[j]!r}"
        if found.halved:
            return "slower than asked: a clearance or a singular pose is close"
        if abs(found.length) < (1 - SAME) * abs(length):
            return "slower than asked: to stop in time, or to follow its curve, within the limits of acceleration"
        if abs(length) < (1 - SAME) * min(abs(asked), LONGEST):
            return "slower than asked: the end of its range is near"
        return f"by {LONGEST} rad, the most in one call"

    def _what_ends(self, wish: Wish, way: _Way, rate: float, why: _Displacement | str | None) -> str:
        """Why there is no displacement."""
        if way.held.any():
            names = [self._joint_of[j] for j in np.flatnonzero(way.held).tolist() if j in self._joint_of]
            return f"at the limit of {', '.join(map(repr, names))}"
        if way.share > ENDED:
            return str(why)
        if wish.column is not None:
            dimension = 0 if self._basis is None else np.count_nonzero(self._basis.any(axis=0))
            return f"the self-motion has {dimension} dimensions here"
        if wish.weights.any():
            return f"{wish.words} cannot {'fall' if rate > 0 else 'rise'} further along the self-motion"
        return f"{wish.words} is at the end of its range along the self-motion, or takes no part in it"


def _first_basis(projector: Array) -> Array:
    """A basis of the range of a projector (n, n), columns of zeros last: the largest projections of unit vectors."""
    left, columns = projector.copy(), np.zeros_like(projector)
    for k in range(round(float(np.trace(projector)))):
        sizes = np.linalg.norm(left, axis=0)
        joint = int(np.argmax(sizes >= (1 - TIE) * sizes.max()))
        columns[:, k] = left[:, joint] / sizes[joint]
        left -= np.outer(columns[:, k], columns[:, k] @ left)
    return columns
