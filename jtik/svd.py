"""The former place of `jtik.symbolic.svd`; kept for one release."""

from jtik.symbolic.svd import *  # noqa: F403
