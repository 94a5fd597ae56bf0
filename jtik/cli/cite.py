"""``jtik cite``: the BibTeX entries of strategies, secondary terms and criteria, by name."""

from __future__ import annotations

import argparse
from typing import Any

from jtik.registry import citations


def add_cite(commands: Any) -> None:
    """Add the command ``cite``."""
    what = "print the sources of strategies and criteria as BibTeX"
    command = commands.add_parser("cite", help=what, description="Sources as BibTeX, each once.")
    command.add_argument(
        "names", nargs="+", metavar="NAME", help="a strategy, a pair such as hybrid+qp, a secondary term, a criterion"
    )
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Print the entries."""
    texts = [str(citations(name)) for name in arguments.names]
    print("\n\n".join(dict.fromkeys(entry for text in texts for entry in text.split("\n\n"))))
    return 0
