"""The command line: ``jtik list``, ``robot``, ``solve``, ``compare``, ``plan``, ``view`` and the others."""

from __future__ import annotations

import argparse
import os
import sys
import warnings
from collections.abc import Sequence
from typing import Any, NoReturn

from jtik.cli import cache, catalogue, compare, plan, robot, solve, view
from jtik.cli.checks import InputError
from jtik.cli.cite import add_cite
from jtik.errors import JtikError

WRONG_INPUT = 2
"""Exit code for input that cannot be used."""

INTERRUPTED = 130
"""Exit code after Ctrl-C."""

CLOSED = 141
"""Exit code when what reads the output has ended, such as ``head``."""

MAX_MESSAGE = 1500
"""Most characters of an error: what was given may be long."""


class _Parser(argparse.ArgumentParser):
    """An argparse parser whose errors are jtik's."""

    def error(self, message: str) -> NoReturn:
        raise InputError(f"{message} (see {self.prog} --help)")


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; ``argv`` is ``sys.argv[1:]`` by default.

    Returns:
        0 when all went well; 1 when a solve did not converge, the demo did not reach a target, a robot has warnings and
        they are checked, or a file could not be written; 2 for wrong input, which one line on stderr explains; 130
        after Ctrl-C.
    """
    words = sys.argv[1:] if argv is None else argv
    with warnings.catch_warnings():
        warnings.simplefilter("always", UserWarning)
        warnings.showwarning = _show_warning
        try:
            arguments = _parser().parse_args([_readable(word) for word in words])
            code: int = arguments.run(arguments)
            sys.stdout.flush()
        except BrokenPipeError:
            sys.stdout = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115  # Python flushes it at the end
            return CLOSED
        except (JtikError, OSError) as error:
            return _refuse(str(error))
        except RecursionError:
            return _refuse("the input is nested too deeply")
        except MemoryError:
            return _refuse("the input needs more memory than there is")
        except KeyboardInterrupt:
            print("jtik: interrupted", file=sys.stderr)
            return INTERRUPTED
    return code


def _refuse(message: str) -> int:
    """Print one line on stderr, and return the exit code for wrong input."""
    line = " ".join(message.split())
    if len(line) > MAX_MESSAGE:
        line = f"{line[: MAX_MESSAGE // 2]} ... {line[-MAX_MESSAGE // 2 :]}"
    print(f"jtik: {line}", file=sys.stderr)
    return WRONG_INPUT


def _show_warning(message: Warning | str, *where: Any, **more: Any) -> None:
    """Print a warning as one line on stderr, without the place in the source."""
    print(f"jtik: warning: {' '.join(str(message).split())}", file=sys.stderr)


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

    catalogue.add_arguments(commands)
    robot.add_arguments(commands)
    solve.add_arguments(commands)
    compare.add_arguments(commands)
    plan.add_arguments(commands)
    view.add_arguments(commands)
    cache.add_arguments(commands)
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
