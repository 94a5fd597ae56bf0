"""Names to plugins: built-ins by decorator, third parties by entry point."""

from __future__ import annotations

import importlib
import subprocess
import sys
import textwrap
import types
import warnings
from pathlib import Path

import numpy as np
import pytest

import jtik
import jtik_formulations
from jtik.registry import Registry, supporting_clearances, table
from jtik.strategy import SecondaryTerm

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

CURIOUS = """
import jtik
from thirdparty_registry import strategies

class Curious(jtik.strategies["hybrid"]):
    seen = list(strategies)
"""


@pytest.fixture
def distribution(tmp_path, monkeypatch):
    """A third party's installed distribution with entry points of our choosing, found by importlib.metadata."""

    def install(**groups):
        (tmp_path / "thirdparty_plugin.py").write_text(PLUGIN)
        (tmp_path / "thirdparty_broken.py").write_text("raise OSError('the disk is full')\n")
        (tmp_path / "thirdparty_exits.py").write_text("raise SystemExit(3)\n")
        info = tmp_path / "third_party-1.0.dist-info"
        info.mkdir()
        (info / "METADATA").write_text("Metadata-Version: 2.1\nName: third-party\nVersion: 1.0\n")
        lines = []
        for group, entries in groups.items():
            lines += [f"[jtik.{group}]", *[f"{name} = {value}" for name, value in entries.items()]]
        (info / "entry_points.txt").write_text("\n".join(lines) + "\n")
        monkeypatch.syspath_prepend(tmp_path)
        for module in ("thirdparty_plugin", "thirdparty_broken", "thirdparty_exits"):
            monkeypatch.delitem(sys.modules, module, raising=False)

    return install


def strategies():
    """A registry like jtik.strategies that has not loaded anything yet."""
    return Registry("strategy", jtik.Strategy, "jtik.strategies")


def criteria():
    return Registry("criterion", jtik.Criterion, "jtik.criteria")


def run(program):
    """A program in a new process, with every warning an error."""
    paths = [path for path in sys.path if path]
    program = f"import sys; sys.path[:0] = {paths!r}\n{textwrap.dedent(program)}"
    subprocess.run([sys.executable, "-W", "error", "-c", program], check=True)


class TestBuiltIns:
    def test_strategies_and_criteria_of_the_paper_are_there(self):
        assert {"transpose", "newton", "hybrid"} <= set(jtik.strategies)
        assert {"joint_centering", "obstacle_avoidance"} <= set(jtik.criteria)
        assert list(jtik.strategies) == sorted(jtik.strategies)
        assert len(jtik.strategies) == len(set(jtik.strategies))

    @pytest.mark.quick(6)
    @pytest.mark.parametrize("name", sorted(jtik.strategies))
    def test_a_strategy_name_stands_for_the_defaults(self, name):
        strategy = jtik.strategies[name]
        assert issubclass(strategy, jtik.Strategy)
        assert strategy.name == name
        assert strategy.summary
        assert strategy.source
        assert jtik.InverseKinematics(planar(2), jtik.FrameTask(), strategy=name).strategy == strategy()

    @pytest.mark.parametrize("name", sorted(jtik.criteria))
    def test_a_criterion_class_says_what_it_is(self, name):
        assert issubclass(jtik.criteria[name], jtik.Criterion)
        assert jtik.criteria[name].summary

    def test_they_are_loaded_when_first_asked_for_and_not_before(self):
        run("""
        import sys, jtik
        assert "jtik_formulations" not in sys.modules
        assert "hybrid" in jtik.strategies
        assert "jtik_formulations" in sys.modules
        """)

    def test_an_unknown_name_lists_the_known(self):
        with pytest.raises(jtik.UnknownNameError, match="unknown strategy 'hybird'; did you mean 'hybrid'") as caught:
            jtik.strategies["hybird"]
        assert {"hybrid", "newton", "transpose"} <= set(caught.value.known)
        with pytest.raises(jtik.UnknownNameError, match="unknown criterion"):
            jtik.criteria["laziness"]

    @pytest.mark.quick(1)
    @pytest.mark.parametrize(
        ("registry", "name", "module"),
        [
            ("strategies", "newton", "strategies.newton"),
            ("criteria", "isotropy", "criteria.isotropy"),
            ("secondaries", "qp", "strategies.qp_secondary"),
        ],
    )
    def test_a_name_loads_the_module_of_the_same_name_alone(self, registry, name, module):
        run(f"""
        import jtik, sys
        jtik.{registry}[{name!r}]
        assert "jtik_formulations.{module}" in sys.modules
        assert "jtik_formulations.strategies.sns" not in sys.modules
        assert "jtik_formulations.criteria.manipulability" not in sys.modules
        """)

    @pytest.mark.quick(1)
    @pytest.mark.parametrize("name", ["sugihara", "mink"])
    def test_a_name_is_found_in_a_module_of_another_name(self, name):
        run(f"import jtik; assert jtik.strategies[{name!r}].name == {name!r}")

    def test_every_registered_class_is_exported(self):
        """Only those are found in a new process."""
        root = Path(jtik_formulations.__file__).parent
        for path in root.rglob("[a-z]*.py"):
            importlib.import_module(".".join(["jtik_formulations", *path.relative_to(root).with_suffix("").parts]))
        classes = {**jtik.strategies, **jtik.criteria, **jtik.secondaries}.values()
        built_in = {each.__name__ for each in classes if each.__module__.startswith("jtik_formulations.")}
        assert built_in <= set(jtik_formulations.__all__)
        assert set(jtik_formulations.__all__) == set(jtik_formulations._MODULES)
        assert all(name in dir(jtik_formulations) for name in jtik_formulations.__all__)

    def test_asking_whether_a_name_is_there_raises_nothing(self):
        assert "hybird" not in jtik.strategies
        assert jtik.strategies.get("hybird") is None


class TestRegistration:
    def test_a_taken_name_is_refused_and_both_classes_are_named(self):
        registry = strategies()
        hybrid = jtik.strategies["hybrid"]
        registry.add("mine", hybrid)
        registry.add("mine", hybrid)  # the same again is no conflict
        with pytest.raises(jtik.ArgumentError) as caught:
            registry.add("mine", jtik.strategies["newton"])
        assert str(caught.value) == (
            "strategy name: given 'mine' for jtik_formulations.strategies.newton.Newton; "
            "accepted: a name not yet taken by jtik_formulations.strategies.hybrid.Hybrid"
        )
        assert registry["mine"] is hybrid

    @pytest.mark.slow
    def test_a_built_in_name_is_taken_before_anything_is_loaded(self):
        """The conflict is reported where the class is defined, not when the built-in classes are loaded later."""
        program = """
        import jtik, sys
        assert "jtik_formulations" not in sys.modules
        try:
            @jtik.register_secondary("qp")
            class Mine(jtik.strategy.SecondaryTerm):
                pass
        except jtik.ArgumentError as error:
            assert "not yet taken by jtik_formulations" in str(error), error
        else:
            raise AssertionError("accepted")
        assert jtik.secondaries["qp"].__name__ == "QPSecondary"
        """
        run(program)

    def test_the_same_class_defined_again_replaces_the_former(self):
        """As a notebook cell does that is run twice."""
        registry = strategies()

        def cell(limit):
            class Mine(jtik.strategies["newton"]):
                q_limit = limit

            registry.add("mine", Mine)

        cell(0.1)
        cell(0.2)
        assert registry["mine"].q_limit == 0.2
        assert list(registry.loaded()) == ["mine"]

    def test_a_class_of_another_module_does_not_replace_one_of_the_same_name(self):
        registry = strategies()
        one, other = (type("Mine", (jtik.strategies["newton"],), {"__module__": module}) for module in ("a", "b"))
        registry.add("mine", one)
        with pytest.raises(jtik.ArgumentError, match=r"given 'mine' for b\.Mine; .*taken by a\.Mine"):
            registry.add("mine", other)

    def test_a_refused_class_keeps_no_trace_of_the_name(self):
        other = type("Other", (jtik.strategies["newton"],), {})
        with pytest.raises(jtik.ArgumentError):
            jtik.register_strategy("hybrid")(other)
        assert other.name == "newton"

    @pytest.mark.parametrize("plugin", [dict, jtik.criteria["joint_centering"], "hybrid", 3])
    def test_a_class_of_another_kind_is_refused(self, plugin):
        with pytest.raises(jtik.ArgumentError, match="strategy 'odd': given .*; accepted: a subclass of Strategy"):
            strategies().add("odd", plugin)

    @pytest.mark.parametrize("name", ["", " ", "a\nb", "newton+mine", 3, None, b"mine", ["mine"]])
    @pytest.mark.parametrize("kind", ["strategy", "secondary", "criterion"])
    def test_a_name_that_nobody_could_ask_for_is_refused_and_listings_stay(self, kind, name):
        listed = {"strategy": jtik.strategies, "secondary": jtik.secondaries, "criterion": jtik.criteria}[kind]
        before, plugin = repr(listed), next(iter(listed.values()))
        with pytest.raises(jtik.ArgumentError, match=r" name: given .*; accepted: a text .* without '\+'"):
            getattr(jtik, f"register_{kind}")(name)(plugin)
        assert repr(listed) == before

    def test_what_is_no_text_in_a_class_does_not_break_a_listing(self):
        registry = strategies()
        odd = type("Odd", (jtik.strategies["newton"],), {"summary": 5, "source": None, "__doc__": 7})
        registry.add("odd", odd)
        registry.add("bare", type("Bare", (odd,), {"summary": "", "__doc__": 7}))
        assert "odd" in repr(registry)
        assert "bare" in registry._repr_html_()

    @pytest.mark.parametrize("kind", ["strategy", "secondary", "criterion"])
    def test_a_decorator_without_a_name_is_refused(self, kind):
        with pytest.raises(
            jtik.ArgumentError, match=r" name: given <class '.*Mine'>; accepted: a text .* without '\+'"
        ):

            @getattr(jtik, f"register_{kind}")
            class Mine:
                pass

    def test_the_decorator_names_the_class(self, monkeypatch):
        registry = strategies()
        monkeypatch.setattr("jtik.registry.decorators.strategies", registry)

        @jtik.register_strategy("mine")
        class Mine(jtik.strategies["hybrid"]):
            pass

        assert Mine.name == "mine"
        assert registry["mine"] is Mine

    def test_every_decorator_adds_to_its_own_registry(self, monkeypatch):
        for kind, plugin in [
            ("strategy", jtik.strategies["newton"]),
            ("secondary", jtik.secondaries["qp"]),
            ("criterion", jtik.criteria["joint_centering"]),
        ]:
            plural = {"strategy": "strategies", "secondary": "secondaries", "criterion": "criteria"}[kind]
            fresh = Registry(kind, plugin.__mro__[-3], f"none.{plural}")
            monkeypatch.setattr(f"jtik.registry.decorators.{plural}", fresh)
            assert getattr(jtik, f"register_{kind}")("mine")(plugin) is plugin
            assert fresh["mine"] is plugin


class TestEntryPoints:
    def test_third_parties_are_found(self, distribution):
        distribution(
            strategies={"patient": "thirdparty_plugin:Patient"},
            criteria={"cautious": "thirdparty_plugin:Cautious"},
        )
        found = strategies()
        patient = found["patient"]
        assert issubclass(patient, jtik.Strategy)
        solution = jtik.InverseKinematics(planar(3), jtik.FrameTask(), strategy=patient()).solve(
            [1.0, 1.0], q0=[0.1] * 3
        )
        assert solution.converged
        assert criteria()["cautious"].name == "cautious"
        assert list(found) == ["patient"]
        assert "patient" in found

    def test_a_third_partys_strategy_carries_the_name_it_is_registered_by(self, distribution):
        distribution(strategies={"patient": "thirdparty_plugin:Patient"})
        assert strategies()["patient"].name == "patient"

    def test_a_name_loads_its_own_plugin_only(self, distribution):
        distribution(strategies={"patient": "thirdparty_plugin:Patient", "broken": "thirdparty_broken:Strategy"})
        registry = strategies()
        registry.add("mine", jtik.strategies["newton"])
        assert registry["mine"] is jtik.strategies["newton"]
        assert "thirdparty_plugin" not in sys.modules
        assert registry.names() == ["broken", "mine", "patient"]
        assert "thirdparty_plugin" not in sys.modules
        assert registry["patient"].name == "patient"
        assert "thirdparty_broken" not in sys.modules

    def test_an_unknown_name_lists_those_of_plugins_without_loading_them(self, distribution):
        distribution(strategies={"patient": "thirdparty_plugin:Patient"})
        with pytest.raises(jtik.UnknownNameError, match="did you mean 'patient'") as caught:
            strategies()["patiant"]
        assert caught.value.known == ("patient",)
        assert "thirdparty_plugin" not in sys.modules

    @pytest.mark.parametrize(
        ("target", "reason"),
        [
            ("thirdparty_broken:Strategy", "OSError: the disk is full"),
            ("thirdparty_exits:Strategy", "SystemExit: 3"),
            ("thirdparty_absent:Strategy", "ModuleNotFoundError: No module named 'thirdparty_absent'"),
            ("thirdparty_plugin:Absent", "AttributeError"),
            ("thirdparty_plugin:Neither", "ArgumentError: strategy 'broken': given <class"),
            ("thirdparty_plugin", "accepted: a subclass of Strategy"),
        ],
    )
    def test_one_that_cannot_be_loaded_names_its_distribution(self, distribution, target, reason):
        distribution(strategies={"broken": target})
        registry = strategies()
        for _ in range(2):  # not once, and then silently without it
            with pytest.raises(jtik.PluginError) as caught:
                registry["broken"]
            assert caught.value.plugin == "broken"
            assert caught.value.distribution == "third-party"
            assert reason in caught.value.reason
            assert str(caught.value) == (
                f"plugin 'broken' of distribution 'third-party' could not be loaded: {caught.value.reason}"
            )
            assert caught.value.__cause__ is not None

    def test_one_with_a_taken_name_leaves_the_name_to_its_owner(self, distribution):
        distribution(strategies={"hybrid": "thirdparty_plugin:Patient"})
        registry = strategies()
        registry.add("hybrid", jtik.strategies["hybrid"])
        assert registry["hybrid"] is jtik.strategies["hybrid"]
        with pytest.warns(
            UserWarning,
            match=r"^plugin 'hybrid' of distribution 'third-party' could not be loaded: ArgumentError: strategy name: "
            r"given 'hybrid' for thirdparty_plugin\.Patient; accepted: a name not yet taken by "
            r"jtik_formulations\.strategies\.hybrid\.Hybrid; it is left out of the strategies$",
        ):
            assert list(registry) == ["hybrid"]
        assert registry["hybrid"] is jtik.strategies["hybrid"]

    @pytest.mark.parametrize(
        "listing",
        [len, list, repr, str, lambda registry: registry._repr_html_(), lambda registry: "broken" in registry],
        ids=["len", "list", "repr", "str", "html", "in"],
    )
    def test_listings_warn_once_and_leave_it_out(self, distribution, listing):
        distribution(strategies={"patient": "thirdparty_plugin:Patient", "broken": "thirdparty_broken:Strategy"})
        registry = strategies()
        with pytest.warns(UserWarning, match="'broken' of distribution 'third-party'.*the disk is full") as caught:
            listing(registry)
        assert len(caught) == 1
        assert Path(caught[0].filename).name in (Path(__file__).name, "mapping.py")  # mapping: str calls repr
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            listing(registry)
            assert list(registry) == ["patient"]
            assert len(registry) == 1
            assert "broken" not in registry
            assert "patient" in registry

    def test_a_plugin_may_list_what_is_registered_while_it_is_loaded(self, distribution, tmp_path):
        distribution(strategies={"curious": "thirdparty_curious:Curious"})
        (tmp_path / "thirdparty_curious.py").write_text(CURIOUS)
        registry = sys.modules["thirdparty_registry"] = types.SimpleNamespace(strategies=strategies())
        try:
            assert registry.strategies["curious"].seen == []
            assert list(registry.strategies) == ["curious"]
        finally:
            for name in ("thirdparty_registry", "thirdparty_curious"):
                sys.modules.pop(name, None)

    def test_another_name_warns_of_nothing(self, distribution):
        distribution(strategies={"patient": "thirdparty_plugin:Patient", "broken": "thirdparty_broken:Strategy"})
        registry = strategies()
        assert registry["patient"].name == "patient"
        assert "patient" in registry
        assert "unknown" not in registry
        assert registry.get("unknown") is None

    def test_one_that_was_mended_is_loaded_when_its_name_is_asked_for_again(self, distribution, tmp_path, monkeypatch):
        distribution(strategies={"broken": "thirdparty_broken:Strategy"})
        registry = strategies()
        with pytest.raises(jtik.PluginError):
            registry["broken"]
        module = type(sys)("thirdparty_broken")
        module.Strategy = type("Strategy", (jtik.strategies["newton"],), {"__module__": "thirdparty_broken"})
        monkeypatch.setitem(sys.modules, "thirdparty_broken", module)
        assert registry["broken"] is module.Strategy
        assert list(registry) == ["broken"]

    def test_a_pair_with_a_broken_secondary_term_names_its_distribution(self, distribution, monkeypatch):
        distribution(secondaries={"broken": "thirdparty_broken:Term"})
        registry = Registry("secondary term", SecondaryTerm, "jtik.secondaries")
        monkeypatch.setattr("jtik.registry.strategy_argument.secondaries", registry)
        with pytest.raises(jtik.PluginError, match="plugin 'broken' of distribution 'third-party'"):
            jtik.InverseKinematics(planar(2), jtik.FrameTask(), strategy="newton+broken")


class TestTable:
    @pytest.mark.parametrize("registry", [jtik.strategies, jtik.criteria, jtik.secondaries], ids=lambda one: one._title)
    def test_it_shows_name_summary_and_source_within_120_characters(self, registry):
        text = repr(registry)
        assert str(registry) == text
        title, headings, *lines = text.splitlines()
        assert title == f"{registry._title}: {len(registry)}"
        assert headings.split() == ["name", "what", "it", "does", "source"]
        assert max(map(len, text.splitlines())) <= 120
        starts = [line.split()[0] for line in lines if not line.startswith(" ")]
        assert starts == list(registry)
        source = headings.index("source")
        shown = " ".join(" ".join(line[source:].split()) for line in lines)
        for plugin in registry.values():
            assert " ".join(getattr(plugin, "source", "").split()) in shown

    def test_columns_are_aligned_and_long_cells_wrapped(self):
        rows = [("a", "one two three four five six seven eight", "S 1"), ("bcd", "nine", "")]
        assert table.text_table("things: 2", rows, width=40).splitlines() == [
            "things: 2",
            "name  what it does                source",
            "a     one two three four five     S 1",
            "      six seven eight",
            "bcd   nine",
        ]

    def test_without_a_width_every_class_has_one_line(self):
        rows = [("a", "much " * 50, "paper")]
        assert len(table.text_table("things: 1", rows, width=None).splitlines()) == 3

    def test_a_class_without_summary_is_described_by_its_docstring(self):
        class Plain:
            """The first line.

            More.
            """

        assert table.rows({"plain": Plain}) == [("plain", "The first line.", "")]
        assert table.rows({"empty": type("Empty", (), {})}) == [("empty", "", "")]

    def test_a_broken_plugin_has_a_row_that_says_why(self, distribution):
        distribution(strategies={"patient": "thirdparty_plugin:Patient", "broken": "thirdparty_broken:Strategy"})
        registry = strategies()
        assert registry.rows()[0] == ("broken", "could not be loaded: OSError: the disk is full", "third-party")
        with pytest.warns(UserWarning, match="left out"):
            lines = repr(registry).splitlines()
        assert lines[0] == "strategies: 1, and 1 broken"
        assert lines[2].startswith("broken   could not be loaded: OSError: the disk is full")
        assert lines[2].endswith("third-party")

    def test_html_is_escaped(self):
        class Angled(jtik.Strategy):
            summary = "keeps |dq| < 1 & <b>bold</b>"
            source = "<script>alert('x')</script>"

        registry = strategies()
        registry.add("<i>", Angled)
        shown = registry._repr_html_()
        assert "<td style='text-align:left'>&lt;i&gt;</td>" in shown
        assert "keeps |dq| &lt; 1 &amp; &lt;b&gt;bold&lt;/b&gt;" in shown
        for raw in ("<i>", "<b>", "<script>"):
            assert raw not in shown


class TestStrategyArgument:
    def test_an_object_is_taken_as_it_is(self):
        newton = jtik.strategies["newton"](q_limit=0.2)
        assert jtik.InverseKinematics(planar(2), jtik.FrameTask(), strategy=newton).strategy is newton

    def test_an_unknown_name_lists_the_known(self):
        with pytest.raises(jtik.UnknownNameError, match="unknown strategy 'gradient'") as caught:
            jtik.InverseKinematics(planar(2), jtik.FrameTask(), strategy="gradient")
        assert {"hybrid", "newton", "transpose"} <= set(caught.value.known)

    @pytest.mark.parametrize("strategy", [None, 3, jtik.strategies["hybrid"], np.zeros(2)])
    def test_something_else_lists_the_names(self, strategy):
        with pytest.raises(jtik.ArgumentError, match="(?s)strategy: .*'hybrid'.*'newton'"):
            jtik.InverseKinematics(planar(2), jtik.FrameTask(), strategy=strategy)

    def test_a_strategy_without_secondary_term_cannot_be_paired(self):
        with pytest.raises(jtik.ArgumentError) as caught:
            jtik.InverseKinematics(planar(2), jtik.FrameTask(), strategy="weighted_qp+qp")
        assert str(caught.value) == (
            "strategy: given weighted_qp+qp; accepted: a strategy with a secondary term before '+', not 'weighted_qp'"
        )

    def test_one_that_needs_arguments_says_which(self, monkeypatch):
        class Needs(jtik.strategies["hybrid"]):
            def __init__(self, radius):
                pass

        monkeypatch.setitem(jtik.strategies._classes, "needs", Needs)
        with pytest.raises(jtik.ArgumentError) as caught:
            jtik.InverseKinematics(planar(2), jtik.FrameTask(), strategy="needs")
        assert str(caught.value) == (
            "strategy: given Needs, which needs radius; accepted: an object: jtik.strategies['needs'](radius=...), "
            "that is Needs(radius=...)"
        )
        assert "'weighted_qp'" in supporting_clearances()  # lists the others all the same

    def test_an_abstract_one_says_what_it_lacks(self, monkeypatch):
        class Half(jtik.Strategy):
            pass

        monkeypatch.setitem(jtik.strategies._classes, "half", Half)
        with pytest.raises(
            jtik.ArgumentError, match="given Half, which is abstract; accepted: a class that defines upd"
        ):
            jtik.InverseKinematics(planar(2), jtik.FrameTask(), strategy="half")

    def test_clearances_with_a_strategy_that_has_none_list_those_that_have(self):
        accepted = supporting_clearances()
        assert accepted.startswith("a strategy whose quadratic programs have rows for them: ")
        assert "'weighted_qp'" in accepted
        assert "'newton+qp'" in accepted
        assert "'newton'," not in accepted
