"""The former place of `jtik.symbolic.factorization`; kept for one release."""

import warnings

from jtik.symbolic.factorization import *  # noqa: F403

warnings.warn("jtik.factorization is now jtik.symbolic.factorization", DeprecationWarning, stacklevel=2)
