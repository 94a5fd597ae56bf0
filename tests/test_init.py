"""``import jtik``: what it loads, what is public, and former names."""

from __future__ import annotations

import subprocess
import sys
import textwrap

import pytest

import jtik

from .conftest import slow

ROOTS = [path for path in sys.path if path]


def run(program: str, *options: str) -> str:
    """What a program prints in a new process that finds what this one finds."""
    code = f"import sys; sys.path[:0] = {ROOTS!r}\n{textwrap.dedent(program)}"
    done = subprocess.run([sys.executable, *options, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_import_loads_numpy_and_casadi_and_nothing_else() -> None:
    """Of what is not in the standard library; and of jtik no study, problems, pictures, bridges or tests."""
    loaded = run("""
        import sys
        before = set(sys.modules)
        import jtik
        new = set(sys.modules) - before
        tops = {name.partition(".")[0] for name in new}
        print(*sorted(tops - set(sys.stdlib_module_names)))
        print(*sorted(name for name in new if name.startswith("jtik.") and name.count(".") == 1))
        print(*sorted(tops & {"asyncio", "multiprocessing", "sqlite3", "http", "unittest", "ctypes"}))
    """)
    tops, subpackages, heavy = (line.split() for line in loaded.splitlines())
    assert {top for top in tops if not top.startswith("swig_runtime_data")} == {"casadi", "jtik", "numpy"}
    for late in ("cli", "demo", "interop", "plotting", "problems", "study", "testing", "viewer"):
        assert f"jtik.{late}" not in subpackages
    assert set(heavy) <= {"ctypes"}  # numpy needs it


@pytest.mark.parametrize(
    "name", ["Comparison", "plotting", *slow("compare", "interop", "problems", "study", "testing")]
)
def test_what_is_loaded_late_is_there_when_it_is_named(name: str) -> None:
    run(f"from jtik import {name}")
    run(f"""
        import jtik
        assert {name!r} in dir(jtik) and {name!r} in jtik.__all__
        assert jtik.{name} is jtik.{name}
    """)


def test_compare_is_the_function_of_the_study() -> None:
    from jtik.study import Comparison, compare

    assert jtik.compare is compare
    assert jtik.Comparison is Comparison


@pytest.mark.parametrize("name", jtik.__all__)
def test_every_public_name_exists(name: str) -> None:
    assert getattr(jtik, name) is not None
    assert name in dir(jtik)


def test_a_star_import_gives_all_of_them() -> None:
    run("""
        import jtik
        from jtik import *
        assert set(jtik.__all__) <= set(globals())
    """)


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="^module 'jtik' has no attribute 'inverse'$"):
        getattr(jtik, "inverse")  # noqa: B009
    with pytest.raises(ImportError, match="cannot import name 'inverse'"):
        exec("from jtik import inverse")


@pytest.mark.parametrize(("old", "new"), [("GaveWay", "Relaxation")])
def test_a_former_name_warns_and_is_the_new_one(old: str, new: str) -> None:
    with pytest.warns(DeprecationWarning, match=f"^jtik.{old} is now jtik.{new}$") as caught:
        assert getattr(jtik, old) is getattr(jtik, new)
    assert caught[0].filename == __file__
    assert old not in dir(jtik)
    assert old not in jtik.__all__


def test_the_docstring_names_the_public_modules_and_they_exist() -> None:
    public = [
        "constraints",
        "criterion",
        "errors",
        "geometry",
        "interop",
        "plotting",
        "problems",
        "progress",
        "qp",
        "registry",
        "result",
        "robot",
        "strategy",
        "study",
        "symbolic",
        "task",
        "testing",
        "types",
        "viewer",
    ]
    for name in public:
        assert f"`jtik.{name}`" in (jtik.__doc__ or "")
    run(f"import importlib\nfor name in {public!r}: importlib.import_module('jtik.' + name)")
