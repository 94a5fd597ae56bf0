"""Colours and sizes of the pictures."""

from __future__ import annotations

from typing import Any

import numpy as np

from jtik.arguments import integer
from jtik.errors import ArgumentError

COLORMAP = "YlGnBu"
"""The colour map of a sequence of postures."""

LIGHTEST = 0.26
"""Where in the colour map a sequence starts; paler colours are lost on white."""

BACKGROUND, INK, MUTED, THIN = "#fdfdfb", "#2b2f36", "#6b7078", "#c3c7cc"
"""Colours of the background, of lines, of labels, and of the frame."""

OBSTACLE_FACE, OBSTACLE_EDGE = "#f3d2ae", "#bf7a3a"
"""Colours of an obstacle: inside, and its edge."""

SINGLE = "#4d86b0"
"""Colour of a single posture in space: light and shade can be seen on it."""

COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", INK)
"""Colours of Okabe and Ito (2008), without yellow, which is hard to see on white."""

LINK_WIDTH = 0.09
"""Drawn width of a link [m]."""

MARGIN = 0.006
"""Margin around the frame, as a share of the figure's width."""


def line_colors(count: int) -> list[Any]:
    """Colours of lines that belong together, such as those of all joints: easy to tell apart, or else in a sequence.

    Args:
        count: how many.
    """
    import matplotlib

    if integer("count", count) <= len(COLORS):
        return list(COLORS[:count])
    return [matplotlib.colormaps["viridis"](share) for share in np.linspace(0.0, 0.88, count)]


def shades(count: int, colormap: str = COLORMAP) -> list[Any]:
    """Colours of a matplotlib colour map, from light to dark; a single one is dark.

    Args:
        count: how many.
        colormap: the colour map's name.

    Raises:
        ArgumentError: when ``count`` is no non-negative integer, or matplotlib has no colour map of that name.
    """
    import matplotlib

    count = integer("count", count)
    if not isinstance(colormap, str) or colormap not in matplotlib.colormaps:
        raise ArgumentError("colormap", repr(colormap), "the name of a colour map of matplotlib")
    chosen = matplotlib.colormaps[colormap]
    return [chosen(LIGHTEST + (1 - LIGHTEST) * share) for share in np.linspace(1, 0, count)[::-1]]
