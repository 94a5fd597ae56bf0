"""Which pairs of a robot's bodies are judged: the rule of `Robot.collision_pairs`."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from jtik.geometry import segment_distances
from jtik.robot.collisions.bodies import CollisionBody
from jtik.robot.collisions.frame_poses import frame_poses
from jtik.robot.collisions.pairs import CollisionPair
from jtik.robot.collisions.reach import axis_point, is_out_of_reach
from jtik.robot.joint_type import JointType
from jtik.robot.skeleton import NEGLIGIBLE

if TYPE_CHECKING:
    from jtik.robot.model import Robot

SAMPLES = 300
"""Random configurations, besides home, at which pairs are measured."""

OFTEN = 1 / 3
"""Share of the sample above which a pair that touches is left out: the capsules are thicker than the bodies.

On nine robots, from a UR5e to a TALOS, the capsules of bodies that really collide touch at up to 27 % of random
configurations. Those of bodies beside each other, whose parts cannot collide, touch at 40 % and more."""

_CHUNK = 200
"""Pairs that are measured at once: it bounds the memory."""


def judged_pairs(robot: Robot, bodies: Sequence[CollisionBody], within: float) -> tuple[CollisionPair, ...]:
    """All pairs of bodies, each with why it is left out, or None; see `Robot.collision_pairs`."""
    judged = []
    occupied = {body.carrier for body in bodies}
    candidates = []
    for i, j in combinations(range(len(bodies)), 2):
        reason = _by_structure(robot, bodies[i], bodies[j], occupied)
        if reason is None:
            candidates.append((i, j))
        else:
            judged.append(((i, j), CollisionPair(bodies[i].name, bodies[j].name, reason)))
    judged += _by_samples(robot, bodies, candidates, within)
    return tuple(pair for _, pair in sorted(judged, key=lambda each: each[0]))


def _by_structure(robot: Robot, a: CollisionBody, b: CollisionBody, occupied: set[str]) -> str | None:
    if a.carrier == b.carrier:
        return "no joint between them"
    disabled = robot.disabled_collisions
    frames = [(x, y) for x in set(a.frames) for y in set(b.frames)]
    reason = next((disabled[pair] for x, y in frames for pair in ((x, y), (y, x)) if pair in disabled), None)
    if reason is not None:
        return f"disabled ({reason})" if reason else "disabled"
    inner, outer = sorted((a.carrier, b.carrier), key=lambda frame: len(robot.path(frame)))
    return "neighbours" if _are_neighbours(robot, inner, outer, occupied) else None


def _are_neighbours(robot: Robot, inner: str, outer: str, occupied: set[str]) -> bool:
    """Whether one joint is between two bodies, or several in one point without a body between them."""
    path, inside = robot.path(outer), robot.path(inner)
    if path[: len(inside)] != inside:
        return False
    between = list(path[len(inside) :])
    while between and not between[0].is_moving:
        between.pop(0)
    for joint in between[1:]:
        away = float(np.linalg.norm(joint.origin[:3, 3])) > NEGLIGIBLE
        if joint.type not in (JointType.FIXED, JointType.REVOLUTE, JointType.BALL) or away or joint.parent in occupied:
            return False
    return True


def _by_samples(
    robot: Robot, bodies: Sequence[CollisionBody], candidates: Sequence[tuple[int, int]], within: float
) -> list[tuple[tuple[int, int], CollisionPair]]:
    """The candidates, measured at home and at random configurations."""
    generator = np.random.default_rng(0)
    q = np.array([robot.home, *[robot.random_configuration(generator) for _ in range(SAMPLES)]])
    poses = frame_poses(robot, q, [frame for body in bodies for frame in body.frames])
    shape = (len(q), 3)
    starts, ends = (
        [np.broadcast_to(axis_point(poses, body, end, robot.dimension), shape) for body in bodies] for end in (0, 1)
    )
    judged = []
    for first in range(0, len(candidates), _CHUNK):
        chunk = candidates[first : first + _CHUNK]
        sides = [np.array([points[pair[k]] for pair in chunk]) for k in (0, 1) for points in (starts, ends)]
        radii = np.array([[bodies[i].radius + bodies[j].radius] for i, j in chunk])
        for (i, j), gap in zip(chunk, segment_distances(*sides) - radii, strict=True):
            touching = float((gap < 0).mean())
            reason = None
            if touching > OFTEN:
                reason = "often touching"
            elif gap.min() > within and is_out_of_reach(robot, bodies[i], bodies[j], within):
                reason = f"never within {within:g} m"
            measured = CollisionPair(bodies[i].name, bodies[j].name, reason, float(gap[0]), float(gap.min()), touching)
            judged.append(((i, j), measured))
    return judged
