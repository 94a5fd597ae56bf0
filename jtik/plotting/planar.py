"""The former place of what is in `jtik.plotting`; kept for one release."""

from jtik.plotting import *  # noqa: F403
