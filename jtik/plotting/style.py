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

LINK_WIDTH = 0.09
"""Drawn width of a link [m]."""

MARGIN = 0.006
"""Margin around the frame, as a share of the figure's width."""


def shades(count: int, colormap: str = COLORMAP) -> list[Any]:
    """Colours of a matplotlib colour map, from light to dark; a single one is dark.

    Args:
        count: how many.
        colormap: the colour map's name.
    """
    import matplotlib

    count = integer("count", count)
    if not isinstance(colormap, str) or colormap not in matplotlib.colormaps:
        raise ArgumentError("colormap", repr(colormap), "the name of a colour map of matplotlib")
    chosen = matplotlib.colormaps[colormap]
    return [chosen(LIGHTEST + (1 - LIGHTEST) * share) for share in np.linspace(1, 0, count)[::-1]]
