"""Functions as C: what CasADi generates, rewritten so that it compiles and runs faster, with the same bits.

`source` is where it begins. Each of the other modules rewrites one thing, or reads statements for those that do.
"""

from jtik.symbolic.generated_c.source import SELDOM, c_source

__all__ = ["SELDOM", "c_source"]
