"""The formulations: one module and one derivation each, side by side in ``formulations/``."""

from jtik_formulations.criteria.joint_centering import JointCentering
from jtik_formulations.criteria.obstacle_avoidance import ObstacleAvoidance
from jtik_formulations.strategies.damped import Damped
from jtik_formulations.strategies.hybrid import Hybrid
from jtik_formulations.strategies.newton import Newton
from jtik_formulations.strategies.projected_gradient import ProjectedGradient
from jtik_formulations.strategies.qp_secondary import QPSecondary
from jtik_formulations.strategies.transpose import Transpose

__all__ = [
    "Damped",
    "Hybrid",
    "JointCentering",
    "Newton",
    "ObstacleAvoidance",
    "ProjectedGradient",
    "QPSecondary",
    "Transpose",
]
