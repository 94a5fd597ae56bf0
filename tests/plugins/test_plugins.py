"""Two installed distributions: ``good`` is found and passes the contracts, ``broken`` affects no other.

Install both first: ``python -m pip install --no-deps tests/plugins/good tests/plugins/broken``.
"""

from __future__ import annotations

import importlib.metadata
import re
import subprocess
import sys
import textwrap

import numpy as np
import pytest

import jtik
from jtik.registry import strategy_of
from jtik.testing import check_criterion, check_strategy, example_criterion

GOOD, BROKEN = "jtik-plugin-example", "jtik-plugin-broken"
INSTALLED = {name.lower() for name in (one.name for one in importlib.metadata.distributions()) if name}

pytestmark = [
    pytest.mark.plugins,
    pytest.mark.skipif(not {GOOD, BROKEN} <= INSTALLED, reason="the distributions of tests/plugins are not installed"),
]

SOLVE = """
arm = jtik.Robot.planar(4)
ik = jtik.InverseKinematics(arm, jtik.FrameTask("tip"), criteria=jtik.criteria["joint_centering"](), strategy={name!r})
assert ik.solve([2.0, 1.0], q0=[0.1, 0.2, 0.3, 0.4]).converged
"""


def run(program: str, *options: str, module: str = "") -> subprocess.CompletedProcess[str]:
    """A program, or ``python -m module`` with these words, in a new process where every warning is an error."""
    paths = [path for path in sys.path if path]
    code = f"import sys; sys.path[:0] = {paths!r}\n{textwrap.dedent(program)}"
    if module:
        code += f"\nimport runpy; sys.argv[1:] = {list(options)!r}; runpy.run_module({module!r}, run_name='__main__')"
    words = [sys.executable, "-W", "error", "-c", code]
    return subprocess.run(words, capture_output=True, text=True, check=False)


def without_output(program: str) -> None:
    """The program ends well and prints nothing."""
    done = run(program)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


class TestGood:
    def test_its_classes_are_found_through_entry_points(self) -> None:
        without_output("""
        import jtik, sys
        assert "jtik_plugin_example" not in sys.modules
        for registry, name in [
            (jtik.criteria, "example_height"),
            (jtik.strategies, "example_newton"),
            (jtik.secondaries, "example_gradient"),
        ]:
            assert registry[name].__module__.startswith("jtik_plugin_example."), registry[name]
            assert registry[name].name == name
            assert name in registry
        """)

    def test_its_classes_are_listed(self) -> None:
        done = run("", "list", module="jtik")
        assert (done.returncode, done.stderr) == (0, "")
        for name in ("example_height", "example_newton", "example_gradient"):
            assert name in done.stdout

    def test_its_criterion_passes_the_contract(self) -> None:
        for robot in (jtik.Robot.planar(4), jtik.Robot.builtin("panda")):
            check_criterion(example_criterion(jtik.criteria["example_height"], robot), robot, samples=5)

    @pytest.mark.parametrize("name", ["example_newton", "newton+example_gradient", "example_newton+example_gradient"])
    def test_its_strategy_and_secondary_term_pass_the_contract(self, name: str) -> None:
        check_strategy(name, samples=1)

    def test_a_pair_is_made_of_its_parts(self) -> None:
        pair = strategy_of("example_newton+example_gradient")
        assert type(pair).__name__ == "ExampleNewton"
        assert type(pair.secondary).__name__ == "ExampleGradient"  # type: ignore[attr-defined]

    def test_its_criterion_acts(self) -> None:
        arm = jtik.Robot.planar(4)
        task = jtik.FrameTask("tip", axes="x")
        ik = jtik.InverseKinematics(
            arm, task, criteria=jtik.criteria["example_height"](), strategy="example_newton+example_gradient"
        )
        solution = ik.solve([2.0, 0.0], q0=[0.1, 0.2, 0.3, 0.4])
        assert solution.converged
        np.testing.assert_allclose(arm.position(solution.q), [2.0, 0.5], atol=1e-3)


class TestBroken:
    @pytest.mark.parametrize("name", ["hybrid", "newton+qp", "example_newton+gradient"])
    def test_it_does_not_disturb_a_solve(self, name: str) -> None:
        without_output(
            "import jtik, sys\n" + SOLVE.format(name=name) + "assert 'jtik_plugin_broken' not in sys.modules"
        )

    def test_it_does_not_disturb_a_comparison(self) -> None:
        without_output("""
        import jtik
        arm = jtik.Robot.planar(3)
        names = ["hybrid", "newton+qp"]
        found = jtik.compare(arm, jtik.FrameTask("tip"), strategies=names, problems="reachable", count=2)
        assert list(found.contenders) == names, found
        """)

    def test_the_list_shows_it_as_broken_and_everything_else(self) -> None:
        done = run("sys.modules['rich'] = None", "list", module="jtik")
        assert (done.returncode, done.stderr) == (0, "")
        lines = done.stdout.splitlines()
        broken = [line for line in lines if line.endswith(BROKEN)]
        assert [line.split()[0] for line in broken] == [
            *("broken_import", "broken_kind", "hybrid"),  # strategies
            "broken_import",  # secondary terms
            *("broken_import", "joint_centering"),  # criteria
        ]
        assert "could not be loaded: ImportError: a library that this plugin needs is not installed" in broken[0]
        for name in ("hybrid", "newton", "joint_centering", "example_newton"):
            assert any(line.startswith(f"{name} ") and not line.endswith(BROKEN) for line in lines)

    def test_the_command_line_solves_beside_it(self) -> None:
        words = "solve --robot planar:3 --target 1 2 --q0 0.1 0.2 0.3 --strategy hybrid --criterion joint_centering"
        done = run("", *words.split(), module="jtik")
        assert (done.returncode, done.stderr) == (0, "")
        assert done.stdout.startswith("Solution: converged")

    def test_iteration_warns_once_for_each_and_yields_the_others(self) -> None:
        without_output("""
        import jtik, warnings
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            names = list(jtik.strategies)
            assert len(jtik.strategies) == len(names)
            repr(jtik.strategies), "broken_kind" in jtik.strategies
        assert "example_newton" in names and "hybrid" in names and "broken_import" not in names
        texts = [str(one.message) for one in caught]
        assert [one.category for one in caught] == [UserWarning] * 3, texts
        for name, text in zip(["broken_import", "broken_kind", "hybrid"], texts, strict=True):
            start = f"plugin {name!r} of distribution 'jtik-plugin-broken' could not be loaded: "
            assert text.startswith(start), text
            assert text.endswith("; it is left out of the strategies"), text
        assert jtik.strategies["hybrid"].__module__ == "jtik_formulations.strategies.hybrid"
        """)

    @pytest.mark.parametrize(
        ("program", "reason"),
        [
            (
                "jtik.strategies['broken_import']",
                "plugin 'broken_import' of distribution 'jtik-plugin-broken' could not be loaded: "
                "ImportError: a library that this plugin needs is not installed",
            ),
            (
                "jtik.criteria['broken_import']",
                "plugin 'broken_import' of distribution 'jtik-plugin-broken' could not be loaded: "
                "ImportError: a library that this plugin needs is not installed",
            ),
            (
                "jtik.InverseKinematics(jtik.Robot.planar(2), jtik.FrameTask(), strategy='newton+broken_import')",
                "plugin 'broken_import' of distribution 'jtik-plugin-broken' could not be loaded: "
                "ImportError: a library that this plugin needs is not installed",
            ),
            (
                "jtik.InverseKinematics(jtik.Robot.planar(2), jtik.FrameTask(), strategy='broken_kind')",
                "plugin 'broken_kind' of distribution 'jtik-plugin-broken' could not be loaded: "
                "ArgumentError: strategy 'broken_kind': given <class 'jtik_plugin_broken.no_strategy.NoStrategy'>; "
                "accepted: a subclass of Strategy",
            ),
        ],
    )
    def test_asking_for_it_by_name_is_an_error_that_names_its_distribution(self, program: str, reason: str) -> None:
        done = run(f"import jtik\n{program}")
        assert done.returncode == 1
        assert f"jtik.registry.plugins.PluginError: {reason}\n" in done.stderr

    def test_on_the_command_line_the_error_is_one_line(self) -> None:
        words = "solve --robot planar:3 --target 1 2 --strategy broken_import"
        done = run("", *words.split(), module="jtik")
        assert (done.returncode, done.stdout) == (2, "")
        assert re.fullmatch("jtik: plugin 'broken_import' of distribution 'jtik-plugin-broken' .*\n", done.stderr)
