"""Classes under names that classes of jtik have."""

from jtik_formulations import Hybrid as BuiltInHybrid
from jtik_formulations import JointCentering as BuiltInJointCentering


class Hybrid(BuiltInHybrid):
    """Not the built-in strategy "hybrid"."""


class JointCentering(BuiltInJointCentering):
    """Not the built-in criterion "joint_centering"."""
