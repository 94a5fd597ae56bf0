"""Self-collision: the bodies of a robot, and the pairs of them that can touch."""

from jtik.robot.collisions.bodies import BodyKind, CollisionBody
from jtik.robot.collisions.pairs import CollisionPair, CollisionPairs, PairNames, pair_names
from jtik.robot.collisions.robot_pairs import Collisions

__all__ = ["BodyKind", "CollisionBody", "CollisionPair", "CollisionPairs", "Collisions", "PairNames", "pair_names"]
