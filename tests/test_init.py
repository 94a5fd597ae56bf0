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
    for late in ("cli", "demo", "interop", "plotting", "problems", "qp", "registry", "solver", "strategy", "study"):
        assert f"jtik.{late}" not in subpackages
    for late in ("testing", "viewer", "_step", "_loop"):
        assert f"jtik.{late}" not in subpackages
    assert set(heavy) <= {"ctypes"}  # numpy needs it


FIRST_ANSWER = """
    import sys
    import jtik
    arm = jtik.Robot.builtin("panda")
    ik = jtik.InverseKinematics(arm, jtik.FrameTask("tip"), strategy={strategy!r})
    assert ik.solve(arm.pose(arm.home), q0=arm.home + 0.1).converged
"""


@pytest.mark.slow
@pytest.mark.parametrize("strategy", ["hybrid", "weighted_qp"])
def test_a_first_answer_loads_what_it_uses(strategy: str) -> None:
    """No other robot or strategy, no solver of quadratic programs but CasADi's, and nothing that reads packages."""
    loaded = set(run(FIRST_ANSWER.format(strategy=strategy) + "    print(*sys.modules)").split())
    assert "jtik.robot.gallery.panda" in loaded
    assert f"jtik_formulations.strategies.{strategy}" in loaded
    others = ("jtik.robot.gallery.gen3", "jtik_formulations.strategies.sns", "jtik_formulations.criteria.isotropy")
    late = ("qpsolvers", "scipy", "mink", "osqp", "email", "json", "hashlib", "importlib.metadata", "numpy.ma")
    assert not loaded & {*others, *late}


@pytest.mark.slow
def test_warming_up_loads_the_second_solver() -> None:
    """So that a step whose program DAQP of CasADi gives up is as fast as the others."""
    run(
        FIRST_ANSWER.format(strategy="weighted_qp")
        + """
    assert "qpsolvers" not in sys.modules
    ik.warm_up()
    assert {"qpsolvers", "daqp"} <= set(sys.modules)
    """
    )


@pytest.mark.quick(1)
@pytest.mark.parametrize(
    "module", ["qp", "registry", "solver", *slow("progress", "strategy", "task", "result", "constraints")]
)
def test_a_public_module_is_there_when_it_is_named(module: str) -> None:
    run(f"""
        import jtik
        assert jtik.{module}.__name__ == "jtik.{module}"
        assert {module!r} in dir(jtik)
    """)


@pytest.mark.parametrize("module", ["bibliography", *slow("criteria", "strategies")])
def test_a_module_of_the_formulations_is_there_when_it_is_named(module: str) -> None:
    run(f"""
        import jtik_formulations
        assert jtik_formulations.{module}.__name__ == "jtik_formulations.{module}"
        assert {module!r} in dir(jtik_formulations)
    """)


def test_the_decorator_is_not_hidden_by_its_module() -> None:
    run("""
        import jtik
        import jtik.criterion.decorator
        from jtik.criterion import criterion
        assert jtik.criterion is criterion
    """)


@pytest.mark.quick(1)
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


@pytest.mark.slow
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
