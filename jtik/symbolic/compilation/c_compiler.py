"""The C compiler of the machine: which one it is, its version, and a call of it whose every failure is one error."""

from __future__ import annotations

import importlib.util
import os
import shlex
import shutil
import signal
import subprocess
import sys
import threading
from contextlib import suppress
from pathlib import Path
from typing import Any

from jtik.errors import JtikError
from jtik.symbolic.compilation.archives import Archive

OPTIONS = ("-O2", "-fno-math-errno")
"""Options of every call: a square root is an instruction, not a call. -O3 makes no generated step faster."""

AVX2 = ("-mavx2",)
"""Option of generated C for processors that have it: vectors of four numbers, instructions with three operands.

Steps take 0.83 to 0.97 times as long. Results are the same bits: a product and a sum that are rounded once have an
option of their own.
"""

PROCESSORS = Path("/proc/cpuinfo")
"""Where Linux says what the processors have."""

ZIG = ("-m", "ziglang", "cc")
"""How the compiler of the package ``ziglang``, which is clang, is called."""

ZIG_CACHE = "zig"
"""Name of the folders in which this compiler keeps files."""

ZIG_OPTIONS = ("-fno-sanitize=all", "-g0", "-mcpu=baseline")
"""Options that turn off what this compiler adds of itself: checks at run time, information for debuggers, and the
instructions of this very processor.

With the latter, products and sums are rounded once instead of twice, a library in a shared home folder ends a process
on an older processor, and LLVM keeps vectors in registers beyond the 16th where `__tls_get_addr` is called, which
overwrites them at its first call in a thread: a wrong step, or the end of the process.
"""

SHOWN = 2000
"""Longest part of a compiler's output in an error, in characters: the end, where the reason is."""

PATIENCE = 2.0
"""How long a compiler that is to end may go on before it is forced to [s]."""


class CompilerError(JtikError):
    """There is no usable C compiler, it failed, or its library cannot be stored or loaded.

    Attributes:
        command: the command that was run, or what else failed.
        output: what the compiler printed, or the reason.
    """

    def __init__(self, command: str, output: str) -> None:
        super().__init__(command, output)
        self.command = command
        self.output = output

    def __str__(self) -> str:
        return f"{self.command}: {self.output}"


def compiler() -> tuple[str, ...]:
    """The command of the compiler: ``$CC``, ``clang``, that of the package ``ziglang``, ``gcc``, or ``cc``.

    The order is that of speed: generated steps by clang are 1.1 to 2 times faster than those by gcc.

    Raises:
        CompilerError: when there is none, or ``$CC`` is no command.
    """
    own = os.environ.get("CC", "")
    if own.strip():
        try:
            return tuple(shlex.split(own, posix=os.name != "nt"))
        except ValueError as error:
            raise CompilerError(f"CC={own}", f"not a command: {error}") from error
    clang = shutil.which("clang")
    if clang:
        return (clang,)
    if importlib.util.find_spec("ziglang"):
        return (sys.executable, *ZIG)
    for name in ("gcc", "cc"):
        found = shutil.which(name)
        if found:
            return (found,)
    raise CompilerError("compiled=True", "no C compiler found; install one, or: pip install ziglang")


def version(command: tuple[str, ...], runs: CompilerRuns | None = None) -> str:
    """What the compiler prints about its version, once a process; empty where it cannot be run.

    Args:
        command: the command of the compiler, as `compiler` returns it.
        runs: runs it, and can end it.
    """
    if command not in _versions:
        try:
            _versions[command] = _run([*command, "--version"], runs=runs)
        except CompilerError:  # compiling reports more
            return ""
    return _versions[command]


_versions: dict[tuple[str, ...], str] = {}


def options(command: tuple[str, ...]) -> tuple[str, ...]:
    """The options of a compiler.

    Args:
        command: the command of the compiler, as `compiler` returns it.
    """
    return (*OPTIONS, *ZIG_OPTIONS) if command[-len(ZIG) :] == ZIG else OPTIONS


def instructions() -> tuple[str, ...]:
    """The option for instructions that this machine has and others may lack; empty where Linux does not name them."""
    try:
        said = PROCESSORS.read_text(encoding="ascii", errors="replace")
    except OSError:
        return ()
    flags = [line.split(":", 1)[1].split() for line in said.splitlines() if line.startswith("flags")]
    return AVX2 if flags and all("avx2" in own for own in flags) else ()


class CompilerRuns:
    """The compilers that run, in any thread, and their end.

    Each has a process group of its own: Ctrl-C on the terminal does not reach it, and its parts end with it.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._processes: set[subprocess.Popen[bytes]] = set()
        self._ended = False

    def run(self, call: list[str], environment: dict[str, str] | None) -> subprocess.CompletedProcess[bytes]:
        """Run a command to its end, in this environment or that of the process.

        Args:
            call: the command and its arguments.
            environment: environment variables; those of the process when None.

        Raises:
            OSError: where it cannot be run, or `end` was called.
        """
        pipes: dict[str, Any] = dict.fromkeys(("stdout", "stderr"), subprocess.PIPE)
        group: dict[str, Any] = {"process_group": 0} if os.name == "posix" else {}
        with self._lock:
            if self._ended:
                raise InterruptedError("the compilation was ended")
            process = subprocess.Popen(call, stdin=subprocess.DEVNULL, env=environment, **pipes, **group)
            self._processes.add(process)
        try:
            output = process.communicate()
        except BaseException:  # Ctrl-C, where it runs in the main thread
            _end(process)
            raise
        finally:
            with self._lock:
                self._processes.discard(process)
        return subprocess.CompletedProcess(call, process.returncode, *output)

    def end(self) -> None:
        """End all that run; what would run later fails."""
        with self._lock:
            self._ended, running = True, list(self._processes)
        for process in running:
            _end(process)


def _end(process: subprocess.Popen[bytes]) -> None:
    """End a command with its parts: it is asked to, which lets it delete its files, and then forced to."""
    for name in ("SIGTERM", "SIGKILL"):
        if process.poll() is None:
            if os.name == "posix":
                with suppress(ProcessLookupError):
                    os.killpg(process.pid, getattr(signal, name))
            else:
                process.terminate()
            with suppress(subprocess.TimeoutExpired):
                process.wait(PATIENCE)


def compile_library(
    command: tuple[str, ...],
    code: Path,
    built: Path,
    archive: Archive | None = None,
    runs: CompilerRuns | None = None,
    more: tuple[str, ...] = (),
) -> None:
    """Compile a file of C to a shared library.

    Args:
        command: the command of the compiler.
        code: the file.
        built: the library to write.
        archive: a static library to link it with; None for none.
        runs: runs the compiler, and can end it.
        more: more options.

    Raises:
        CompilerError: when the compiler cannot be run or fails, or what it wrote is no complete library.
    """
    said = [*command, *options(command), *more]
    files = [str(code), "-o", str(built)]
    if archive is not None:
        files = [f"-I{archive.include}", *files, str(archive.file)]
        if sys.platform == "linux":  # it calls its own copy, not one of another version that the process has loaded
            files.append("-Wl,-Bsymbolic")
    _run([*said, "-shared", "-fPIC", *files, "-lm"], said=said, scratch=built.parent, runs=runs)
    try:
        data = built.read_bytes()
    except OSError as error:
        raise CompilerError(
            shlex.join(said), f"the compiler reported success, but there is no library: {error}"
        ) from error
    if not is_complete(data):
        reason = f"the compiler reported success, but its {len(data)} bytes are no complete shared library"
        raise CompilerError(shlex.join(said), reason)


def is_complete(data: bytes) -> bool:
    """Whether a shared library begins as one and, where it is an ELF file, is as long as its headers say.

    Args:
        data: the bytes of the file.
    """
    if data[:4] != b"\x7fELF":
        return data[:2] == b"MZ" or data[:4] in (b"\xcf\xfa\xed\xfe", b"\xca\xfe\xba\xbe")
    if len(data) < 64:
        return False
    order = "little" if data[5] == 1 else "big"

    def number(at: int, size: int) -> int:
        return int.from_bytes(data[at : at + size], order)  # type: ignore[arg-type]

    wide = data[4] == 2
    sections = number(40, 8) if wide else number(32, 4)
    size, count = (number(58, 2), number(60, 2)) if wide else (number(46, 2), number(48, 2))
    return sections > 0 and sections + size * count <= len(data)


def _run(
    call: list[str], said: list[str] | None = None, scratch: Path | None = None, runs: CompilerRuns | None = None
) -> str:
    """What a command prints to stdout. Raises CompilerError, with the command as ``said``, when it fails.

    Zig's compiler keeps what it compiles: where a folder ``scratch`` is given the object in it, and its own libraries,
    which take some seconds at the first call, beside it.
    """
    name = shlex.join(said or call)
    environment = None
    if scratch is not None:
        local, shared = scratch / ZIG_CACHE, scratch.parent / ZIG_CACHE
        environment = {"ZIG_GLOBAL_CACHE_DIR": str(shared), **os.environ, "ZIG_LOCAL_CACHE_DIR": str(local)}
    try:
        run = (runs or CompilerRuns()).run(call, environment)
    except (OSError, ValueError) as error:
        raise CompilerError(name, str(error)) from error
    if run.returncode:
        output = (run.stderr.strip() or run.stdout.strip()).decode(errors="replace")
        raise CompilerError(name, output[-SHOWN:] or f"exit status {run.returncode}, without a message")
    return run.stdout.decode(errors="replace")
