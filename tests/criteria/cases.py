"""Every criterion of posture, limits, dexterity and visibility on ten links and on the Panda, for tests of all."""

from __future__ import annotations

from jtik_formulations import LimitActivation, LimitBarrier, LimitCentering, LimitNorm

CASES = {
    "limit_centering": lambda robot: LimitCentering(),
    "limit_barrier": lambda robot: LimitBarrier(),
    "limit_activation": lambda robot: LimitActivation(),
    "limit_norm": lambda robot: LimitNorm(),
}
"""Criteria by name, each made for a robot."""
