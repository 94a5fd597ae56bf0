"""``jtik cache``: the compiled libraries that are kept."""

from __future__ import annotations

import argparse
from typing import Any

from jtik.symbolic.compilation import library_cache


def add_arguments(commands: Any) -> None:
    """Add the command ``cache`` to argparse's subparsers."""
    what = "the compiled libraries that are kept"
    command = commands.add_parser("cache", help=what, description=f"Show or delete {what}.")
    command.add_argument("action", choices=("info", "clear"), help="show where they are and their size, or delete them")
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Show what the cache holds, or delete it."""
    clears = arguments.action == "clear"
    held = library_cache.clear() if clears else library_cache.info()
    size = f"{held.libraries} libraries, {held.size / 2**20:.1f} MiB"
    if clears:
        print(f"deleted from {held.folder}: {size}")
    else:
        print(
            f"folder  {held.folder}\nholds   {size}\nlimit   {held.limit / 2**20:.0f} MiB, then the least recently used"
        )
    return 0
