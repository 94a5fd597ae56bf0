"""The built-in strategies, secondary terms and criteria: one module each, with its derivation in ``formulations/``."""

from jtik_formulations.criteria.compact_posture import CompactPosture
from jtik_formulations.criteria.directional_manipulability import DirectionalManipulability
from jtik_formulations.criteria.frame_proximity import FrameProximity
from jtik_formulations.criteria.isotropy import Isotropy
from jtik_formulations.criteria.joint_centering import JointCentering
from jtik_formulations.criteria.khatib_potential import KhatibPotential
from jtik_formulations.criteria.limit_activation import LimitActivation
from jtik_formulations.criteria.limit_barrier import LimitBarrier
from jtik_formulations.criteria.limit_centering import LimitCentering
from jtik_formulations.criteria.limit_norm import LimitNorm
from jtik_formulations.criteria.look_at import LookAt
from jtik_formulations.criteria.manipulability import Manipulability
from jtik_formulations.criteria.minimum_displacement import MinimumDisplacement
from jtik_formulations.criteria.obstacle_avoidance import ObstacleAvoidance
from jtik_formulations.criteria.obstacle_barrier import ObstacleBarrier
from jtik_formulations.criteria.smallest_singular_value import SmallestSingularValue
from jtik_formulations.criteria.soft_clearance import SoftClearance
from jtik_formulations.criteria.swivel_angle import SwivelAngle
from jtik_formulations.criteria.visibility import Visibility
from jtik_formulations.strategies.damped import Damped
from jtik_formulations.strategies.damping_rules import ConstantDamped, NakamuraHanafusa, Sugihara
from jtik_formulations.strategies.hybrid import Hybrid
from jtik_formulations.strategies.jparse import JParse
from jtik_formulations.strategies.lexicographic_qp import LexicographicQP
from jtik_formulations.strategies.mink_ik import Mink
from jtik_formulations.strategies.newton import Newton
from jtik_formulations.strategies.projected_gradient import ProjectedGradient
from jtik_formulations.strategies.qp_secondary import QPSecondary
from jtik_formulations.strategies.second_order import SecondOrder
from jtik_formulations.strategies.selectively_damped import SelectivelyDamped
from jtik_formulations.strategies.sns import SNS
from jtik_formulations.strategies.sns_qp import SNSQP
from jtik_formulations.strategies.task_priority import TaskPriority
from jtik_formulations.strategies.transpose import Transpose
from jtik_formulations.strategies.transpose_bb import TransposeBB
from jtik_formulations.strategies.weighted_least_norm import WeightedLeastNorm
from jtik_formulations.strategies.weighted_qp import WeightedQP

__all__ = [
    "SNS",
    "SNSQP",
    "CompactPosture",
    "ConstantDamped",
    "Damped",
    "DirectionalManipulability",
    "FrameProximity",
    "Hybrid",
    "Isotropy",
    "JParse",
    "JointCentering",
    "KhatibPotential",
    "LexicographicQP",
    "LimitActivation",
    "LimitBarrier",
    "LimitCentering",
    "LimitNorm",
    "LookAt",
    "Manipulability",
    "MinimumDisplacement",
    "Mink",
    "NakamuraHanafusa",
    "Newton",
    "ObstacleAvoidance",
    "ObstacleBarrier",
    "ProjectedGradient",
    "QPSecondary",
    "SecondOrder",
    "SelectivelyDamped",
    "SmallestSingularValue",
    "SoftClearance",
    "Sugihara",
    "SwivelAngle",
    "TaskPriority",
    "Transpose",
    "TransposeBB",
    "Visibility",
    "WeightedLeastNorm",
    "WeightedQP",
]
