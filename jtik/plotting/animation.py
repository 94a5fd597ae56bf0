"""Animations: a figure that changes from frame to frame, as a GIF."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from jtik.arguments import path as read_path
from jtik.arguments import positive_integer, positive_number
from jtik.errors import ArgumentError, MissingExtraError
from jtik.plotting.figure import Figure


def write_animation(
    path: str | Path,
    figure: Figure,
    draw: Callable[[int], None],
    frames: int,
    *,
    seconds: float = 0.06,
    hold: float = 1.2,
) -> None:
    """Write an animation as a GIF that repeats.

    Args:
        path: the file to write.
        figure: a figure of `blank_figure`; the animation has its size and dpi.
        draw: changes the figure to frame k; called with 0, 1, ... frames - 1.
        frames: number of frames.
        seconds: time that a frame is shown [s].
        hold: time that the last frame is shown [s].

    Raises:
        MissingExtraError: when pillow is not installed.
    """
    path, frames = read_path("path", path), positive_integer("frames", frames)
    seconds, hold = positive_number("seconds", seconds), positive_number("hold", hold)
    if not callable(draw):
        raise ArgumentError("draw", draw, "a function that is called with the number of a frame")
    try:
        from PIL import Image
    except ImportError as error:
        raise MissingExtraError("pillow", "plot", "an animation") from error
    pictures = []
    for k in range(frames):
        draw(k)
        figure.canvas.draw()
        pictures.append(Image.fromarray(np.asarray(figure.canvas.buffer_rgba())[..., :3].copy()))
    palette = pictures[-1].quantize(96, dither=Image.Dither.NONE)
    indexed = [picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in pictures]
    durations = [round(1000 * seconds)] * (frames - 1) + [round(1000 * hold)]
    indexed[0].save(path, save_all=True, append_images=indexed[1:], duration=durations, loop=0, optimize=True)
