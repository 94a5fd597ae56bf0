"""The former place of `jtik.symbolic.svd`; kept for one release."""

import warnings

from jtik.symbolic.svd import *  # noqa: F403

warnings.warn("jtik.svd is now jtik.symbolic.svd", DeprecationWarning, stacklevel=2)
