"""The contract every criterion and every strategy must meet, ours and those of third parties.

Call `check_criterion` and `check_strategy` in the tests of a plugin; what does not hold raises an AssertionError that
says what was expected, or the JtikError that a user would have met.
"""

from jtik.testing.criteria import check_criterion, example_criterion
from jtik.testing.strategies import check_strategy

__all__ = ["check_criterion", "check_strategy", "example_criterion"]
