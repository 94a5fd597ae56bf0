"""Names to plugins: built-ins by decorator, third parties by entry point."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

import jtik
from jtik.registry import Registry

from .conftest import planar

PLUGIN = """
import jtik
from jtik.strategy import Strategy

class Patient(jtik.strategies["hybrid"]):
    pass

class Cautious(jtik.Criterion):
    name = "cautious"
    def value(self, kinematics, parameters):
        return kinematics.q[0] ** 2

class Neither:
    pass
"""


@pytest.fixture
def distribution(tmp_path, monkeypatch):
    """A third party's installed distribution with entry points of our choosing, found by importlib.metadata."""

    def install(**groups):
        (tmp_path / "thirdparty_plugin.py").write_text(PLUGIN)
        (tmp_path / "thirdparty_broken.py").write_text("raise OSError('the disk is full')\n")
        info = tmp_path / "third_party-1.0.dist-info"
        info.mkdir()
        (info / "METADATA").write_text("Metadata-Version: 2.1\nName: third-party\nVersion: 1.0\n")
        lines = []
        for group, entries in groups.items():
            lines += [f"[jtik.{group}]", *[f"{name} = {value}" for name, value in entries.items()]]
        (info / "entry_points.txt").write_text("\n".join(lines) + "\n")
        monkeypatch.syspath_prepend(tmp_path)
        for module in ("thirdparty_plugin", "thirdparty_broken"):
            monkeypatch.delitem(sys.modules, module, raising=False)

    return install


def strategies():
    """A registry like jtik.strategies that has not loaded anything yet."""
    return Registry("strategy", jtik.Strategy, "jtik.strategies")


def criteria():
    return Registry("criterion", jtik.Criterion, "jtik.criteria")


class TestBuiltIns:
    def test_strategies_and_criteria_of_the_paper_are_there(self):
        assert {"transpose", "newton", "hybrid"} <= set(jtik.strategies)
        assert {"joint_centering", "obstacle_avoidance"} <= set(jtik.criteria)
        assert list(jtik.strategies) == sorted(jtik.strategies)
        assert len(jtik.strategies) == len(set(jtik.strategies))

    @pytest.mark.parametrize("name", sorted(jtik.strategies))
    def test_a_strategy_name_stands_for_the_defaults(self, name):
        law = jtik.strategies[name]
        assert issubclass(law, jtik.Strategy)
        assert law.name == name
        assert law.summary
        assert law.source
        assert jtik.InverseKinematics(planar(2), jtik.FrameTask(), strategy=name).strategy == law()

    @pytest.mark.parametrize("name", sorted(jtik.criteria))
    def test_a_criterion_class_says_what_it_is(self, name):
        assert issubclass(jtik.criteria[name], jtik.Criterion)
        assert jtik.criteria[name].summary

    def test_they_are_loaded_when_first_asked_for_and_not_before(self):
        script = (
            "import sys, jtik; assert 'jtik_formulations' not in sys.modules; "
            "assert 'hybrid' in jtik.strategies; assert 'jtik_formulations' in sys.modules"
        )
        paths = [path for path in sys.path if path]
        program = f"import sys; sys.path[:0] = {paths!r}; {script}"
        subprocess.run([sys.executable, "-c", program], check=True)

    def test_an_unknown_name_lists_the_known(self):
        with pytest.raises(jtik.UnknownNameError, match="unknown strategy 'hybird'; did you mean 'hybrid'") as caught:
            jtik.strategies["hybird"]
        assert {"hybrid", "newton", "transpose"} <= set(caught.value.known)
        with pytest.raises(jtik.UnknownNameError, match="unknown criterion"):
            jtik.criteria["laziness"]

    def test_asking_whether_a_name_is_there_raises_nothing(self):
        assert "hybird" not in jtik.strategies
        assert jtik.strategies.get("hybird") is None


class TestRegistration:
    def test_a_taken_name_is_refused(self):
        registry = strategies()
        law = jtik.strategies["hybrid"]
        registry.add("mine", law)
        registry.add("mine", law)  # the same again is no conflict
        with pytest.raises(jtik.ArgumentError, match=r"strategy name.*mine.*not yet taken by .*Hybrid"):
            registry.add("mine", jtik.strategies["newton"])
        with pytest.raises(jtik.ArgumentError, match="not yet taken"):
            jtik.register_strategy("hybrid")(type("Other", (law,), {}))
        assert jtik.strategies["hybrid"] is law

    def test_a_refused_class_keeps_no_trace_of_the_name(self):
        other = type("Other", (jtik.strategies["newton"],), {})
        with pytest.raises(jtik.ArgumentError):
            jtik.register_strategy("hybrid")(other)
        assert other.name == "newton"

    @pytest.mark.parametrize("plugin", [dict, jtik.criteria["joint_centering"], "hybrid", 3])
    def test_a_class_of_another_kind_is_refused(self, plugin):
        with pytest.raises(jtik.ArgumentError, match="a subclass of Strategy"):
            strategies().add("odd", plugin)

    def test_the_decorator_names_the_class(self, monkeypatch):
        registry = strategies()
        monkeypatch.setattr("jtik.registry.strategies", registry)

        @jtik.register_strategy("mine")
        class Mine(jtik.strategies["hybrid"]):
            pass

        assert Mine.name == "mine"
        assert registry["mine"] is Mine


class TestEntryPoints:
    def test_third_parties_are_found(self, distribution):
        distribution(
            strategies={"patient": "thirdparty_plugin:Patient"},
            criteria={"cautious": "thirdparty_plugin:Cautious"},
        )
        found = strategies()
        law = found["patient"]
        assert issubclass(law, jtik.Strategy)
        solution = jtik.InverseKinematics(planar(3), jtik.FrameTask(), strategy=law()).solve([1.0, 1.0], q0=[0.1] * 3)
        assert solution.converged
        assert criteria()["cautious"].name == "cautious"

    def test_a_third_partys_strategy_carries_the_name_it_is_registered_by(self, distribution):
        distribution(strategies={"patient": "thirdparty_plugin:Patient"})
        assert strategies()["patient"].name == "patient"

    @pytest.mark.parametrize(
        ("target", "reason"),
        [
            ("thirdparty_broken:Law", "OSError: the disk is full"),
            ("thirdparty_absent:Law", "ModuleNotFoundError"),
            ("thirdparty_plugin:Absent", "AttributeError"),
        ],
    )
    def test_one_that_cannot_be_loaded_names_its_distribution(self, distribution, target, reason):
        distribution(strategies={"broken": target})
        with pytest.raises(jtik.PluginError, match="third-party") as caught:
            len(strategies())
        assert caught.value.plugin == "broken"
        assert caught.value.distribution == "third-party"
        assert reason in caught.value.reason

    @pytest.mark.parametrize("name", ["odd", "hybrid"])
    def test_one_of_another_kind_or_with_a_taken_name_names_its_distribution(self, distribution, name):
        plugin = "Neither" if name == "odd" else "Patient"
        distribution(strategies={name: f"thirdparty_plugin:{plugin}"})
        registry = strategies()
        registry.add("hybrid", jtik.strategies["hybrid"])
        with pytest.raises(jtik.JtikError, match="third-party"):
            len(registry)

    def test_a_broken_one_is_told_every_time(self, distribution):
        """Not once, and then silently without it."""
        distribution(strategies={"broken": "thirdparty_broken:Law"})
        registry = strategies()
        for _ in range(2):
            with pytest.raises(jtik.PluginError):
                registry["broken"]


class TestStrategyArgument:
    def test_an_object_is_taken_as_it_is(self):
        law = jtik.strategies["newton"](q_limit=0.2)
        assert jtik.InverseKinematics(planar(2), jtik.FrameTask(), strategy=law).strategy is law

    def test_an_unknown_name_lists_the_known(self):
        with pytest.raises(jtik.UnknownNameError, match="unknown strategy 'gradient'") as caught:
            jtik.InverseKinematics(planar(2), jtik.FrameTask(), strategy="gradient")
        assert {"hybrid", "newton", "transpose"} <= set(caught.value.known)

    @pytest.mark.parametrize("strategy", [None, 3, jtik.strategies["hybrid"], np.zeros(2)])
    def test_something_else_lists_the_names(self, strategy):
        with pytest.raises(jtik.ArgumentError, match="(?s)strategy: .*'hybrid'.*'newton'"):
            jtik.InverseKinematics(planar(2), jtik.FrameTask(), strategy=strategy)
