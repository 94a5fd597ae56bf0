"""Results: plain data that can be pickled and read in any thread. No file here imports the engine."""

from jtik.result.batch import SolutionBatch
from jtik.result.jog import Jog
from jtik.result.relaxation import Relaxation
from jtik.result.report import Report
from jtik.result.solution import Solution
from jtik.result.status import Status
from jtik.result.step import Step
from jtik.result.trace import Trace
from jtik.result.trajectory import Trajectory

__all__ = ["Jog", "Relaxation", "Report", "Solution", "SolutionBatch", "Status", "Step", "Trace", "Trajectory"]
