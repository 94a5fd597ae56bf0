"""Static libraries that CasADi comes with, which generated C is linked with instead of calling CasADi."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import casadi

ARCHIVES = {"daqp": ("libdaqpstat.a", "daqp/api.h")}
"""By conic plugin: its static library, and the header that generated C includes."""


class Archive(NamedTuple):
    """A static library.

    Attributes:
        file: the library.
        include: the folder of its headers.
    """

    file: Path
    include: Path


def archive_of(plugin: str) -> Archive | None:
    """The static library of a conic plugin; None where CasADi came without it.

    Args:
        plugin: name of CasADi's plugin, such as "daqp".
    """
    if plugin not in ARCHIVES:
        return None
    folder, (file, header) = Path(casadi.__file__).parent, ARCHIVES[plugin]
    found = Archive(folder / file, folder / "include")
    return found if found.file.is_file() and (found.include / header).is_file() else None
