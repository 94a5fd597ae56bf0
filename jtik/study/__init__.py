"""Studies: strategies on the same problems, measured and judged alike."""

from jtik.study.compare import compare
from jtik.study.comparison import Comparison
from jtik.study.contender import Answer, Contender, Ready, Setting
from jtik.study.rows import Row
from jtik.study.strategies import Law

__all__ = ["Answer", "Comparison", "Contender", "Law", "Ready", "Row", "Setting", "compare"]
