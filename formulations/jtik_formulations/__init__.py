"""The built-in strategies, secondary terms and criteria: one module each, with its derivation in ``formulations/``.

A module is imported, and what it has registered, when a name of it is first used.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from jtik_formulations.criteria.compact_posture import CompactPosture
    from jtik_formulations.criteria.directional_manipulability import DirectionalManipulability
    from jtik_formulations.criteria.effective_mass import EffectiveMass
    from jtik_formulations.criteria.frame_proximity import FrameProximity
    from jtik_formulations.criteria.gravity_torque import GravityTorque
    from jtik_formulations.criteria.isotropy import Isotropy
    from jtik_formulations.criteria.joint_centering import JointCentering
    from jtik_formulations.criteria.khatib_potential import KhatibPotential
    from jtik_formulations.criteria.kinetic_energy import KineticEnergy
    from jtik_formulations.criteria.limit_activation import LimitActivation
    from jtik_formulations.criteria.limit_barrier import LimitBarrier
    from jtik_formulations.criteria.limit_centering import LimitCentering
    from jtik_formulations.criteria.limit_norm import LimitNorm
    from jtik_formulations.criteria.look_at import LookAt
    from jtik_formulations.criteria.manipulability import Manipulability
    from jtik_formulations.criteria.minimum_displacement import MinimumDisplacement
    from jtik_formulations.criteria.obstacle_avoidance import ObstacleAvoidance
    from jtik_formulations.criteria.obstacle_barrier import ObstacleBarrier
    from jtik_formulations.criteria.self_collision import SelfCollision
    from jtik_formulations.criteria.smallest_singular_value import SmallestSingularValue
    from jtik_formulations.criteria.soft_clearance import SoftClearance
    from jtik_formulations.criteria.support_polygon import SupportPolygon
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
    "EffectiveMass",
    "FrameProximity",
    "GravityTorque",
    "Hybrid",
    "Isotropy",
    "JParse",
    "JointCentering",
    "KhatibPotential",
    "KineticEnergy",
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
    "SelfCollision",
    "SmallestSingularValue",
    "SoftClearance",
    "Sugihara",
    "SupportPolygon",
    "SwivelAngle",
    "TaskPriority",
    "Transpose",
    "TransposeBB",
    "Visibility",
    "WeightedLeastNorm",
    "WeightedQP",
]

_MODULES = {
    "CompactPosture": "criteria.compact_posture",
    "DirectionalManipulability": "criteria.directional_manipulability",
    "EffectiveMass": "criteria.effective_mass",
    "FrameProximity": "criteria.frame_proximity",
    "GravityTorque": "criteria.gravity_torque",
    "Isotropy": "criteria.isotropy",
    "JointCentering": "criteria.joint_centering",
    "KhatibPotential": "criteria.khatib_potential",
    "KineticEnergy": "criteria.kinetic_energy",
    "LimitActivation": "criteria.limit_activation",
    "LimitBarrier": "criteria.limit_barrier",
    "LimitCentering": "criteria.limit_centering",
    "LimitNorm": "criteria.limit_norm",
    "LookAt": "criteria.look_at",
    "Manipulability": "criteria.manipulability",
    "MinimumDisplacement": "criteria.minimum_displacement",
    "ObstacleAvoidance": "criteria.obstacle_avoidance",
    "ObstacleBarrier": "criteria.obstacle_barrier",
    "SelfCollision": "criteria.self_collision",
    "SmallestSingularValue": "criteria.smallest_singular_value",
    "SoftClearance": "criteria.soft_clearance",
    "SupportPolygon": "criteria.support_polygon",
    "SwivelAngle": "criteria.swivel_angle",
    "Visibility": "criteria.visibility",
    "Damped": "strategies.damped",
    "ConstantDamped": "strategies.damping_rules",
    "NakamuraHanafusa": "strategies.damping_rules",
    "Sugihara": "strategies.damping_rules",
    "Hybrid": "strategies.hybrid",
    "JParse": "strategies.jparse",
    "LexicographicQP": "strategies.lexicographic_qp",
    "Mink": "strategies.mink_ik",
    "Newton": "strategies.newton",
    "ProjectedGradient": "strategies.projected_gradient",
    "QPSecondary": "strategies.qp_secondary",
    "SecondOrder": "strategies.second_order",
    "SelectivelyDamped": "strategies.selectively_damped",
    "SNS": "strategies.sns",
    "SNSQP": "strategies.sns_qp",
    "TaskPriority": "strategies.task_priority",
    "Transpose": "strategies.transpose",
    "TransposeBB": "strategies.transpose_bb",
    "WeightedLeastNorm": "strategies.weighted_least_norm",
    "WeightedQP": "strategies.weighted_qp",
}
"""The module of each class."""

_LAZY_MODULES = ("bibliography", "criteria", "strategies")

if not TYPE_CHECKING:  # a type checker then still finds misspelled names

    def __getattr__(name: str) -> Any:
        """A class, whose module is imported on first use, or a module."""
        if name in _LAZY_MODULES:
            return importlib.import_module(f"{__name__}.{name}")
        if name in _MODULES:
            found = globals()[name] = getattr(importlib.import_module(f"{__name__}.{_MODULES[name]}"), name)
            return found
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *_MODULES, *_LAZY_MODULES})
