"""The former place of `jtik.symbolic.factorization`; kept for one release."""

from jtik.symbolic.factorization import *  # noqa: F403
