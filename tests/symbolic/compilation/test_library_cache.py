"""The cache of compiled libraries: what may be loaded, what is built again, and what faults leave behind."""

from __future__ import annotations

import logging
import os
import signal
import stat
import subprocess
import sys
import time
from pathlib import Path

import pytest

from jtik.symbolic import function, symbol
from jtik.symbolic.compilation import c_compiler, library_cache
from jtik.symbolic.compilation.c_compiler import compile_library
from jtik.symbolic.compile import CompilerError, compiler, library

needs_a_compiler = pytest.mark.skipif(
    not any(os.access(os.path.join(folder, "cc"), os.X_OK) for folder in os.environ["PATH"].split(os.pathsep)),
    reason="no C compiler",
)
needs_root = pytest.mark.skipif(not hasattr(os, "getuid") or os.getuid() != 0, reason="mounts need root")
pytestmark = needs_a_compiler


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    library_cache._temporary.cache_clear()
    return tmp_path / "jtik"


def example(name="example"):
    x = symbol("x", 2)
    return function(name, [x], [x[0] * 3 + x[1]])


def value(made):
    return float(made.function([2.0, 1.0]))


def left(folder):
    return [each.name for each in folder.iterdir()] if folder.exists() else []


def script(path, text):
    path.write_text(f"#!{sys.executable}\n{text}")
    path.chmod(0o755)
    return path


def test_folder_and_library_are_the_users_alone_and_compiled_once(cache):
    made = library(example())
    assert value(made) == 7
    assert stat.S_IMODE(cache.stat().st_mode) == 0o700
    assert stat.S_IMODE(Path(made.path).stat().st_mode) == 0o700
    written = Path(made.path).stat().st_ino
    assert library(example()).path == made.path
    assert Path(made.path).stat().st_ino == written
    assert len(left(cache)) == 1


def test_a_folder_of_an_earlier_version_becomes_private(cache):
    cache.mkdir(mode=0o755)
    library(example())
    assert stat.S_IMODE(cache.stat().st_mode) == 0o700


def planted(cache):
    """A library with the same names as the real one that gives another number."""
    real = Path(library(example()).path)
    text = f"#include <stddef.h>\nint {real.stem.rpartition('-')[0]}(void) {{ return 1; }}\n"
    code = cache.parent / "planted.c"
    code.write_text(text)
    compile_library(compiler(), code, code.with_suffix(".so"))
    return real, code.with_suffix(".so").read_bytes()


def test_a_planted_file_is_not_loaded_but_replaced(cache):
    real, other = planted(cache)
    good = real.read_bytes()
    real.unlink()  # so that the process has no mapping of the file that is overwritten
    real.write_bytes(other)
    assert value(library(example())) == 7
    assert real.read_bytes() == good


@pytest.mark.quick(2)
@pytest.mark.parametrize("harm", ["truncated", "flipped", "empty", "link", "folder"])
def test_a_damaged_file_is_built_again(cache, harm):
    real = Path(library(example()).path)
    good = real.read_bytes()
    real.unlink()
    if harm == "truncated":
        real.write_bytes(good[: len(good) // 2])
    elif harm == "flipped":
        real.write_bytes(bytes([*good[:700], good[700] ^ 1, *good[701:]]))
    elif harm == "empty":
        real.write_bytes(b"")
    elif harm == "link":
        elsewhere = cache.parent / "elsewhere.so"
        elsewhere.write_bytes(good)
        real.symlink_to(elsewhere)
    else:
        real.mkdir()
    assert value(library(example())) == 7
    assert real.read_bytes() == good
    assert not real.is_symlink()


@needs_root
def test_a_file_of_another_owner_is_built_again(cache):
    real = Path(library(example()).path)
    os.chown(real, 12345, -1)
    assert value(library(example())) == 7
    assert real.stat().st_uid == 0


def test_a_file_that_others_can_change_is_built_again(cache):
    real = Path(library(example()).path)
    real.chmod(0o777)
    assert value(library(example())) == 7
    assert stat.S_IMODE(real.stat().st_mode) == 0o700


@pytest.mark.quick(2)
@pytest.mark.parametrize("fault", ["world-writable", "of another owner", "a file", "no home"])
def test_without_a_private_folder_the_libraries_are_temporary(cache, monkeypatch, caplog, fault):
    if fault == "no home":
        monkeypatch.delenv("XDG_CACHE_HOME")
        monkeypatch.setattr(Path, "home", lambda: (_ for _ in ()).throw(RuntimeError("no home folder")))
    elif fault == "a file":
        cache.write_text("")
    else:
        cache.mkdir()
        if fault == "world-writable":
            cache.chmod(0o777)
        elif os.getuid() == 0:
            os.chown(cache, 12345, -1)
        else:
            pytest.skip("needs root")
    with caplog.at_level(logging.WARNING):
        made = library(example())
    assert value(made) == 7
    assert not Path(made.path).is_relative_to(cache)
    assert stat.S_IMODE(Path(made.path).parent.stat().st_mode) == 0o700
    assert "until this process ends" in caplog.text
    assert left(cache) == [] if cache.is_dir() else True


def mounted(folder, options):
    folder.mkdir(parents=True)
    run = subprocess.run(["mount", "-t", "tmpfs", "-o", options, "tmpfs", str(folder)], capture_output=True)
    if run.returncode:
        pytest.skip(f"no mount: {run.stderr.decode(errors='replace')}")


@pytest.fixture
def mount(cache):
    yield lambda options: mounted(cache, options)
    subprocess.run(["umount", "-l", str(cache)], capture_output=True)


@needs_root
def test_a_read_only_folder(cache, mount, caplog):
    mount("ro,mode=700")
    made = library(example())
    assert value(made) == 7
    assert "Read-only file system" in caplog.text


@needs_root
@pytest.mark.parametrize("size", ["4k", "8k", "16k"])
def test_a_full_disk_is_an_error_that_leaves_nothing(cache, mount, size):
    mount(f"size={size},mode=700")
    with pytest.raises(CompilerError, match="No space left|no complete shared library|cannot be stored"):
        library(example())
    assert left(cache) == []


@needs_root
def test_a_folder_from_which_nothing_may_run(cache, mount):
    mount("noexec,mode=700")
    with pytest.raises(CompilerError, match="cannot be loaded.*XDG_CACHE_HOME"):
        library(example())
    assert left(cache) == []


WRITE = "import sys; open(sys.argv[sys.argv.index('-o') + 1], 'wb').write(%s) if '-o' in sys.argv else print('1.0')"


@pytest.mark.quick(3)
@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (WRITE % "b'junk'", "4 bytes are no complete shared library"),
        (WRITE % "b'\\x7fELF' + b'\\1' * 60 + b'\\0' * 400", "no complete shared library"),
        (WRITE % "open('/proc/self/exe', 'rb').read(5000)", "no complete shared library"),
        ("print('1.0')", "there is no library"),
        ("import sys; sys.stderr.buffer.write(b'f\\xfcr \\xff'); sys.exit('-o' in sys.argv)", "f\ufffdr \ufffd"),
        ("import sys; sys.exit(3 if '-o' in sys.argv else 0)", "exit status 3, without a message"),
    ],
)
def test_a_compiler_that_misbehaves(cache, monkeypatch, text, reason):
    odd = script(cache.parent / "odd compiler", text)
    monkeypatch.setenv("CC", f"'{odd}'")
    with pytest.raises(CompilerError) as caught:
        library(example())
    assert reason in str(caught.value)
    assert "odd compiler" in str(caught.value)
    assert left(cache) == []


@pytest.mark.slow
def test_a_library_without_the_function_is_not_kept(cache, monkeypatch):
    empty = cache.parent / "empty.c"
    empty.write_text("int nothing;\n")
    command = list(compiler())
    other = f"import subprocess, sys; sys.exit(subprocess.call({command!r} + [{str(empty)!r} if a.endswith('.c') else a"
    odd = script(cache.parent / "cc", other + " for a in sys.argv[1:]]))")
    monkeypatch.setenv("CC", str(odd))
    with pytest.raises(CompilerError, match="cannot be loaded"):
        library(example())
    assert left(cache) == []


def test_the_words_of_cc_are_those_of_a_shell(monkeypatch):
    monkeypatch.setenv("CC", "'/opt/my compiler/cc' -DNAME='a b'")
    assert compiler() == ("/opt/my compiler/cc", "-DNAME=a b")
    monkeypatch.setenv("CC", "'cc")
    with pytest.raises(CompilerError, match="CC='cc: not a command"):
        compiler()


@pytest.mark.parametrize(
    ("on_path", "zig", "chosen"),
    [
        (("clang", "gcc", "cc"), True, "clang"),
        (("gcc", "cc"), True, "ziglang"),
        (("gcc", "cc"), False, "gcc"),
        (("cc",), False, "cc"),
    ],
)
def test_the_fastest_compiler_is_taken(tmp_path, monkeypatch, on_path, zig, chosen):
    for name in on_path:
        script(tmp_path / name, "")
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr(c_compiler.importlib.util, "find_spec", lambda name: object() if zig else None)
    assert compiler() == ((sys.executable, "-m", "ziglang", "cc") if chosen == "ziglang" else (str(tmp_path / chosen),))


def test_without_a_compiler_the_message_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr(c_compiler.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(CompilerError, match=r"no C compiler found; .*pip install ziglang"):
        compiler()


@pytest.mark.parametrize("command", ["gcc", "ziglang"])
def test_every_compiler_leaves_one_library_and_the_same_number(cache, monkeypatch, command):
    if command == "ziglang":
        pytest.importorskip("ziglang")
        monkeypatch.setenv("CC", f"{sys.executable} -m ziglang cc")
    else:
        monkeypatch.setenv("CC", "gcc")
    assert value(library(example())) == 7
    assert len(left(cache)) == 1


def test_what_a_compiler_keeps_beside_the_libraries_is_cleared(cache):
    (cache / "zig" / "o").mkdir(parents=True)
    cache.chmod(0o700)
    library(example())
    library_cache.clear()
    assert left(cache) == []


def test_another_version_of_the_compiler_or_of_jtik_or_another_machine_is_another_library(cache, monkeypatch):
    import jtik

    names = {library(example()).name}
    monkeypatch.setattr(c_compiler, "_run", lambda call, **_: "another version")
    c_compiler._versions.clear()
    monkeypatch.setattr(
        "jtik.symbolic.compilation.library_cache.find_or_build", lambda key, build: names.add(key) or 1 / 0
    )
    with pytest.raises(ZeroDivisionError):
        library(example())
    c_compiler._versions.clear()
    monkeypatch.setattr(jtik, "__version__", "99")
    with pytest.raises(ZeroDivisionError):
        library(example())
    monkeypatch.setattr("platform.machine", lambda: "another")
    with pytest.raises(ZeroDivisionError):
        library(example())
    c_compiler._versions.clear()
    assert len(names) == 4


def test_the_least_recently_used_are_deleted_above_the_limit(cache, monkeypatch):
    paths = [Path(library(example(f"example{i}")).path) for i in range(3)]
    for age, path in zip((30, 20, 10), paths, strict=True):
        os.utime(path, (time.time() - age, time.time() - age))
    library(example("example0"))  # used again: now the most recent
    monkeypatch.setattr(library_cache, "LIMIT", 3 * paths[0].stat().st_size + 100)
    abandoned = cache / f"{library_cache.SCRATCH}x"
    abandoned.mkdir()
    os.utime(abandoned, (0, 0))
    newest = Path(library(example("example3")).path)
    assert set(left(cache)) == {paths[0].name, paths[2].name, newest.name}


def test_the_command_line_shows_and_clears_the_cache(cache, capsys):
    from jtik.cli import main

    library(example())
    assert main(["cache", "info"]) == 0
    assert f"folder  {cache}\nholds   1 libraries" in capsys.readouterr().out
    assert main(["cache", "clear"]) == 0
    assert left(cache) == []
    assert library_cache.info().libraries == 0


KILLED = """
import sys
from jtik.symbolic import function, symbol
from jtik.symbolic.compile import library
x = symbol("x", 2)
print("ready", flush=True)
library(function("example", [x], [x[0] * 3 + x[1]]))
"""


@pytest.mark.slow
def test_a_compilation_that_is_killed_leaves_nothing_that_is_loaded(cache):
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(each for each in sys.path if each)}
    for moment in range(0, 10, 3):
        with subprocess.Popen([sys.executable, "-c", KILLED], stdout=subprocess.PIPE, env=environment) as process:
            process.stdout.readline()
            time.sleep(0.013 * moment)
            process.send_signal(signal.SIGKILL)
        stored = [name for name in left(cache) if name.endswith(".so")]
        assert value(library(example())) == 7
        assert all(library_cache._is_intact(cache / name) for name in stored)
        library_cache.clear()
        assert left(cache) == []
