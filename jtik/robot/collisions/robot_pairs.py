"""The pairs of a robot's bodies that can touch, as methods of `Robot`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import Any

from jtik.arguments import choice, mapping, non_negative_number
from jtik.errors import ArgumentError, UnknownNameError
from jtik.robot.collisions.bodies import BodyKind, collision_bodies
from jtik.robot.collisions.pairs import CollisionPairs, PairNames
from jtik.robot.collisions.rule import judged_pairs


class Collisions:
    """The methods of `Robot` for its own collisions."""

    _disabled_collisions: dict[tuple[str, str], str]
    _judged: dict[tuple[str, float, float], CollisionPairs]

    @property
    def disabled_collisions(self) -> Mapping[tuple[str, str], str]:
        """Pairs of frames whose collisions are not considered, such as those of an SRDF, each with its reason."""
        return MappingProxyType(self._disabled_collisions)

    def collision_pairs(
        self,
        *,
        exclude: PairNames = (),
        include: PairNames = (),
        bodies: BodyKind | None = None,
        radius: float = 0.05,
        within: float = 0.02,
    ) -> CollisionPairs:
        """The pairs of this robot's own bodies that can touch, and the others with the reason why they are left out.

        A body is the capsule around a solid, or a link. The first of these that is true leaves a pair out:

        - No joint is between the two.
        - The pair is in `disabled_collisions`, which an SRDF fills.
        - They are neighbours: one joint is between them, or several in one point without another body between them.
        - They touch at more than a third of 301 configurations: `home` and random ones within the limits, always the
          same. The capsules are then thicker than the bodies.
        - They never come within ``within`` of each other. This is proved by intervals of the joints between them,
          within the limits, for up to four joints; a pair for which the proof does not succeed is kept.

        Print the result for a table. To change it name pairs: ``exclude=[("hand", "link5")]`` or, for all pairs with
        one body, ``exclude=["link0"]``.

        Args:
            exclude: pairs that are left out, by the names of their frames or bodies.
            include: pairs that are kept, whatever the rule says.
            bodies: "shapes", the solids as capsules; or "links", the links of the skeleton. None for the solids of a
                robot that has any, else the links.
            radius: radius of the links [m].
            within: distance [m] below which a pair counts as one that can touch; not less than what a clearance of
                these pairs keeps, ``safe`` and ``margin`` together.

        Raises:
            ArgumentError: when an argument is none of these, ``bodies`` is "shapes" on a robot without solids, or a
                pair is excluded and included.
            UnknownNameError: when there is no body of a name.
        """
        robot: Any = self
        radius = non_negative_number("radius", radius, "a non-negative length [m]")
        within = non_negative_number("within", within, "a non-negative distance [m]")
        if bodies is None:
            bodies = "shapes" if robot.shapes else "links"
        choice("bodies", bodies, ("shapes", "links"))
        if bodies == "shapes" and not robot.shapes:
            raise ArgumentError("bodies", f"'shapes' on {robot!r}, which has no solids", "'links'")
        key = (bodies, radius if bodies == "links" else 0.0, within)
        if key not in self._judged:
            found = collision_bodies(robot, bodies, radius)
            judged = judged_pairs(robot, found, within)
            self._judged[key] = CollisionPairs(
                {body.name: body for body in found},
                tuple(pair for pair in judged if pair.left_out is None),
                tuple(pair for pair in judged if pair.left_out is not None),
            )
        return self._judged[key].changed(exclude, include)


def disabled_pairs(frames: Iterable[str], given: object) -> dict[tuple[str, str], str]:
    """The argument ``disabled_collisions`` of `Robot`. Raises UnknownNameError for a frame that does not exist."""
    accepted = "a dict from pairs of frames to reasons, such as {('hand', 'link5'): 'never'}, or None"
    known = tuple(frames)
    pairs = {} if given is None else mapping("disabled_collisions", given, accepted)
    for pair, reason in pairs.items():
        if not isinstance(pair, tuple) or len(pair) != 2 or not isinstance(reason, str):
            raise ArgumentError("disabled_collisions", given, accepted)
        for frame in pair:
            if frame not in known:
                raise UnknownNameError("frame", frame, known)
    return pairs
