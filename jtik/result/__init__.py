"""What a user holds: plain data that explains itself and imports no engine file."""

from jtik.result.solution import Solution, Status, Step, Trace
from jtik.result.trajectory import Trajectory

__all__ = ["Solution", "Status", "Step", "Trace", "Trajectory"]
