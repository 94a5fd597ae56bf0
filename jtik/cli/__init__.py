"""The command line: ``jtik list``, ``jtik solve``, ``jtik compare`` and ``jtik demo``."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from typing import NoReturn

from jtik.cli import catalogue, compare, solve
from jtik.cli.checks import InputError
from jtik.cli.cite import add_cite
from jtik.errors import JtikError

WRONG_INPUT = 2
"""Exit code for input that cannot be used."""


class _Parser(argparse.ArgumentParser):
    """An argparse parser whose errors are jtik's."""

    def error(self, message: str) -> NoReturn:
        raise InputError(f"{message} (see {self.prog} --help)")


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; ``argv`` is ``sys.argv[1:]`` by default.

    Returns:
        0 when all went well; 1 when a solve did not converge, or the demo did not reach a target; 2 for wrong input,
        which one line on stderr explains; 130 after Ctrl-C in a comparison.
    """
    words = sys.argv[1:] if argv is None else argv
    try:
        arguments = _parser().parse_args([_readable(word) for word in words])
        code: int = arguments.run(arguments)
    except (JtikError, OSError) as error:
        print(f"jtik: {' '.join(str(error).split())}", file=sys.stderr)
        return WRONG_INPUT
    return code


def _readable(word: str) -> str:
    """The word, with a blank before a negative number: argparse then reads even -1e-3 as a value, not as an option."""
    try:
        float(word)
    except ValueError:
        return word
    return f" {word}" if word.startswith("-") else word


def _parser() -> argparse.ArgumentParser:
    from jtik import __version__

    parser = _Parser(prog="jtik", description="Inverse kinematics for redundant robots.")
    parser.add_argument("--version", action="version", version=f"jtik {__version__}")
    commands = parser.add_subparsers(metavar="command", required=True, parser_class=_Parser)

    what = "the registered strategies, secondary terms and criteria, and the built-in robots"
    command = commands.add_parser("list", help=what, description=f"List {what}.")
    command.set_defaults(run=catalogue.run)

    solve.add_arguments(commands)
    compare.add_arguments(commands)
    add_cite(commands)

    what = "a ten-link arm moves between obstacles"
    command = commands.add_parser("demo", help=what, description="The demo: pictures, an animation, and results.")
    command.add_argument("--out", default="jtik-demo", metavar="DIR", help="folder to write (default: %(default)s)")
    command.add_argument("--quick", action="store_true", help="fewer targets and frames")
    command.set_defaults(run=_demo)
    return parser


def _demo(arguments: argparse.Namespace) -> int:
    from jtik import demo
    from jtik.errors import MissingExtraError

    try:
        from rich.console import Console
    except ImportError as error:
        raise MissingExtraError("rich", "demo", "the demo") from error
    return 0 if demo.run(arguments.out, quick=arguments.quick, console=Console()).path.complete else 1
