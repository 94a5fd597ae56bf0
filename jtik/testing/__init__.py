"""Contract tests for criteria and strategies, jtik's own and those of third parties.

Call `check_criterion` and `check_strategy` in the tests of a plugin. A violation raises an AssertionError with
what was expected, or the JtikError that a solver would raise.
"""

from jtik.testing.criteria import check_criterion, example_criterion
from jtik.testing.strategies import check_strategy

__all__ = ["check_criterion", "check_strategy", "example_criterion"]
