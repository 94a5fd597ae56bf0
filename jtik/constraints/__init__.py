"""Constraints: limits of position, velocity and acceleration, the box of a step, and clearances."""

from jtik.constraints.clearance import Clearance
from jtik.constraints.limits import Limits
from jtik.constraints.measure import Measure

__all__ = ["Clearance", "Limits", "Measure"]
