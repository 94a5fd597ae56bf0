"""Reads the constraints of a MuJoCo model: linear ones become couplings of joints, the others are noted."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import mujoco
import numpy as np

from jtik.robot.loaders.robot_description import JointCoupling


class ConstraintReader:
    """Reads the equalities, the tendons and the ranges of the ball joints of one ``mujoco.MjModel``.

    A linear equality of joints, of a fixed tendon of two joints, or of two tendons that have two joints together, is a
    coupling. Of a tendon's joints the last one that does not follow already is the follower.

    Args:
        model: the ``mujoco.MjModel``.
        joints: the name of each joint.
        bodies: the name of each body.

    Attributes:
        couplings: the couplings of joints.
        notes: one sentence for each constraint that is not kept.
    """

    def __init__(self, model: Any, joints: Sequence[str], bodies: Sequence[str]) -> None:
        self._model, self._joints, self._bodies = model, joints, bodies
        self.couplings: list[JointCoupling] = []
        self.notes: list[str] = []
        self._of_joints()
        held = self._of_tendons()
        self._others()
        self._tendons(held)
        self._ball_ranges()

    def _active(self) -> Iterator[tuple[int, Any]]:
        """The number and the type of each active equality."""
        model = self._model
        for number in np.flatnonzero(model.eq_active0):
            yield int(number), mujoco.mjtEq(int(model.eq_type[number]))

    def _of_joints(self) -> None:
        """The linear equalities of joints; those of higher order are noted and left out."""
        model = self._model
        for number in (number for number, kind in self._active() if kind == mujoco.mjtEq.mjEQ_JOINT):
            joint, leader = int(model.eq_obj1id[number]), int(model.eq_obj2id[number])
            constant, ratio, *higher = map(float, model.eq_data[number][:5])
            here = float(model.qpos0[model.jnt_qposadr[joint]])
            if leader < 0:
                self._add(joint, None, 0.0, here + constant)
                continue
            if any(higher):
                text = f"joint {self._joints[joint]!r} stays independent: it follows {self._joints[leader]!r} "
                self.notes.append(text + "by a polynomial of higher order than one")
                continue
            leader_offset = float(model.qpos0[model.jnt_qposadr[leader]])
            self._add(joint, leader, ratio, here + constant - ratio * leader_offset)

    def _of_tendons(self) -> set[int]:
        """The equalities of tendons; returns the tendons that they hold."""
        model = self._model
        held = set()
        for number in (number for number, kind in self._active() if kind == mujoco.mjtEq.mjEQ_TENDON):
            first, second = int(model.eq_obj1id[number]), int(model.eq_obj2id[number])
            constant, ratio, *higher = map(float, model.eq_data[number][:5])
            who = f"the equality {self._name(mujoco.mjtObj.mjOBJ_EQUALITY, number)} of the tendon {self._tendon(first)}"
            tendons = [first] if second < 0 else [first, second]
            held.update(tendons)
            terms = [self._terms(tendon) for tendon in tendons]
            if any(term is None for term in terms) or (second >= 0 and any(higher)):
                self.notes.append(f"{who} is not kept: it is not linear in the positions of joints")
                continue
            total = dict(terms[0] or {})
            length = float(model.tendon_length0[first]) + constant
            if second >= 0:
                length -= ratio * float(model.tendon_length0[second])
                for joint, factor in (terms[1] or {}).items():
                    total[joint] = total.get(joint, 0.0) - ratio * factor
            self._linear(who, total, length)
        return held

    def _others(self) -> None:
        """Note the equalities of other kinds, such as closed loops."""
        model, kinds = self._model, mujoco.mjtObj
        for number, kind in self._active():
            if kind in (mujoco.mjtEq.mjEQ_JOINT, mujoco.mjtEq.mjEQ_TENDON):
                continue
            what = kind.name.removeprefix("mjEQ_").lower()
            who = f"the equality {self._name(kinds.mjOBJ_EQUALITY, number)} ({what})"
            ends = [int(model.eq_obj1id[number]), int(model.eq_obj2id[number])]
            if kind in (mujoco.mjtEq.mjEQ_CONNECT, mujoco.mjtEq.mjEQ_WELD):
                if model.eq_objtype[number] == int(kinds.mjOBJ_SITE):
                    named = [f"the site {self._name(kinds.mjOBJ_SITE, end)}" for end in ends]
                else:
                    named = [repr(self._bodies[end]) for end in ends]
                self.notes.append(f"{who} of {' and '.join(named)} is not kept: the loop stays open")
            else:
                self.notes.append(f"{who} is not kept")

    def _tendons(self, held: set[int]) -> None:
        """The limits of tendons, and the tendons that are moved as one."""
        model = self._model
        trn = mujoco.mjtTrn.mjTRN_TENDON
        following = {coupling.joint for coupling in self.couplings}
        followers = {number for number, name in enumerate(self._joints) if name in following}
        moved = {int(model.actuator_trnid[k, 0]) for k in range(model.nu) if model.actuator_trntype[k] == int(trn)}
        for tendon in range(model.ntendon):
            if tendon in held:
                continue
            terms = self._terms(tendon)
            lower, upper = map(float, model.tendon_range[tendon])
            who = f"the tendon {self._tendon(tendon)}"
            if model.tendon_limited[tendon]:
                self.notes.append(
                    f"the range of {who}, {lower:g} to {upper:g}, is not kept{_over(self._listed(terms))}"
                )
            elif tendon in moved and terms is not None and len(terms.keys() - followers) > 1:
                listed = self._listed(terms)
                self.notes.append(f"{who} is not kept: one actuator moves the joints {listed}, which stay independent")

    def _ball_ranges(self) -> None:
        model = self._model
        ball = model.jnt_type == int(mujoco.mjtJoint.mjJNT_BALL)
        for joint in map(int, np.flatnonzero(ball & (model.jnt_limited != 0))):
            largest = float(model.jnt_range[joint][1])
            self.notes.append(f"the range of the ball joint {self._joints[joint]!r}, {largest:g} rad, is not kept")

    def _terms(self, tendon: int) -> dict[int, float] | None:
        """The factor of each joint in the length of a fixed tendon; None for a spatial tendon."""
        model = self._model
        first, count = int(model.tendon_adr[tendon]), int(model.tendon_num[tendon])
        terms: dict[int, float] = {}
        for wrap in range(first, first + count):
            if model.wrap_type[wrap] != int(mujoco.mjtWrap.mjWRAP_JOINT):
                return None
            joint = int(model.wrap_objid[wrap])
            terms[joint] = terms.get(joint, 0.0) + float(model.wrap_prm[wrap])
        return terms

    def _linear(self, who: str, terms: Mapping[int, float], total: float) -> None:
        """Keep the constraint that the sum of factor times position is ``total``, where two joints at most have it."""
        factors = {joint: factor for joint, factor in terms.items() if factor}
        if len(factors) > 2:
            self.notes.append(f"{who} is not kept: it couples more than two joints, {self._listed(factors)}")
            return
        followers = {coupling.joint for coupling in self.couplings}
        free = [joint for joint in factors if self._joints[joint] not in followers]
        if not free:
            if factors:
                self.notes.append(f"{who} is not kept: the joints {self._listed(factors)} follow others already")
            return
        joint = free[-1]
        own = factors.pop(joint)
        leader = next(iter(factors), None)
        self._add(joint, leader, 0.0 if leader is None else -factors[leader] / own, total / own)

    def _add(self, joint: int, leader: int | None, ratio: float, offset: float) -> None:
        leading = None if leader is None else self._joints[leader]
        name = self._joints[joint]
        self.couplings.append(JointCoupling(joint=name, leader=leading, multiplier=ratio, offset=offset))

    def _listed(self, terms: Mapping[int, float] | None) -> str:
        return ", ".join(repr(self._joints[joint]) for joint in terms or {})

    def _tendon(self, tendon: int) -> str:
        return self._name(mujoco.mjtObj.mjOBJ_TENDON, tendon)

    def _name(self, kind: Any, number: int) -> str:
        """The name of an element in quotes, or its number."""
        given = mujoco.mj_id2name(self._model, int(kind), number)
        return repr(str(given)) if given else f"number {number}"


def _over(joints: str) -> str:
    return f"; it limits the joints {joints}" if joints else ""
