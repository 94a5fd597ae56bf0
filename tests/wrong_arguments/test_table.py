"""Every argument of the public surface with every wrong value: an error of jtik, and never another one."""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Iterator

import pytest

import jtik
from jtik.errors import CallError

from .surface import ENTRIES, OF_OPTIONS, PROBLEMS, STUDY
from .trial import faults

SLOW = {"compare", *PROBLEMS} - {"Case", "ProblemSet", "obstacles_of", "named", "path", "five_families"}
SLOW |= {"Planner", "check_criterion", "draw_base", "draw_obstacles", "draw_path", "draw_postures", "view"}
"""Entries whose accepted values run a study, draw problems or pictures, or make a planner."""


@pytest.mark.parametrize(
    "name", [pytest.param(each, marks=pytest.mark.slow) if each in SLOW else each for each in ENTRIES]
)
def test_every_wrong_value_is_refused_and_every_right_one_accepted(name):
    _, found = faults(name)
    assert not found, "\n".join(map(str, found))


MODULES = (
    "jtik",
    "jtik.task",
    "jtik.robot",
    "jtik.constraints",
    "jtik.qp",
    "jtik.problems",
    "jtik.study",
    "jtik.planner",
    "jtik.plotting",
    "jtik.testing",
    "jtik.viewer",
)

NOT_CALLED: dict[str, str] = {
    **dict.fromkeys(("CollisionBody", "CollisionPair", "CollisionPairs"), "a result: the library makes it"),
    **dict.fromkeys(
        (
            "Jog",
            "Solution",
            "SolutionBatch",
            "Step",
            "Trace",
            "Trajectory",
            "Relaxation",
            "Answer",
            "Row",
            "Comparison",
        ),
        "a result: the library makes it",
    ),
    **dict.fromkeys(
        ("Criterion", "Measure", "Strategy", "Task", "PlacementTask", "PointingTask", "Contender", "PreparedContender"),
        "a base class",
    ),
    **dict.fromkeys(("JointType", "Status"), "an enumeration"),
    "Kind": "an alias",
    **dict.fromkeys(
        ("Kinematics", "TaskRows", "TaskStack", "WeightedCoordinates", "Setting"),
        "the library makes it from arguments",
    ),
    "Viewer": "`view` makes it",
    "configurations_of": "reads the argument of `posture_figure`, which is in the table",
    "NamedProblem": "a value of `named`",
    **dict.fromkeys(("names", "available"), "takes no argument"),
    **dict.fromkeys(("CalledBackend", "FusedBackend", "QPSolver"), "a base class"),
    **dict.fromkeys(
        ("Elastic", "NumericQP", "QPRecorder", "QPSolution", "QuadraticProgram", "RecordedQP", "Rows", "as_problem"),
        "expressions of a strategy, which tests/qp/test_wrong_input.py covers",
    ),
    **dict.fromkeys(("Axes", "Figure", "Window"), "an alias"),
    **dict.fromkeys(("frame_axes", "label_axes", "points_per_metre"), "takes axes of matplotlib"),
    "example_criterion": "takes a class",
}
"""Public names that the table leaves out, and why."""

METHODS_LEFT_OUT = {
    "InverseKinematics.whole": "a former name",
    "InverseKinematics.reset": "takes no argument",
}


def public() -> Iterator[tuple[str, object]]:
    for module in MODULES:
        found = importlib.import_module(module)
        for name in getattr(found, "__all__", []):
            value = getattr(found, name)
            if callable(value) and not (isinstance(value, type) and issubclass(value, Exception)):
                yield name, value
    for owner in (jtik.Robot, jtik.InverseKinematics):
        for name in dir(owner):
            if not name.startswith("_") and callable(getattr(owner, name)):
                yield f"{owner.__name__}.{name}", getattr(owner, name)
    for registry in (jtik.strategies, jtik.secondaries, jtik.criteria):
        for name in registry.loaded():
            if registry[name].__module__.startswith("jtik_formulations"):
                yield name, registry[name]


LEFT_OUT = {
    ("Robot.configuration", "argument"),
    ("Robot.joint_values", "argument"),
    ("Robot.velocity_values", "argument"),
    ("Clearance", "recover"),
    ("InverseKinematics.build", "program"),
    ("near_singular", "bend"),
    ("near_singular", "far"),
    ("to_urdf", "turn"),
    ("check_criterion", "criterion"),
    ("write_animation", "figure"),
    ("Robot.plot", "options"),
    ("Conic", "options"),
    ("QPSolversBackend", "options"),
    ("PersistentOSQP", "options"),
    ("new_figure", "options"),
    ("draw_path", "style"),
    *(("DrawnArm", style) for style in ("color", "joints", "zorder", "halo")),
    *((each, "axes") for each in ("DrawnArm", "draw_base", "draw_obstacles", "draw_path", "draw_postures")),
}
"""Former names of arguments, names for messages, and what is handed on to another library."""


@pytest.mark.parametrize(("name", "value"), [pytest.param(*each, id=each[0]) for each in public()])
def test_the_table_knows_every_public_argument(name, value):
    """An argument that is added is added to the table, or this fails."""
    if name in NOT_CALLED or name in METHODS_LEFT_OUT:
        return
    arguments = [each for each in inspect.signature(value).parameters if each != "self"]
    known = {*ENTRIES[name].kinds} | {argument for entry, argument in LEFT_OUT if entry == name}
    assert set(arguments) == known


def test_nothing_in_the_table_is_gone():
    names = {name for name, _ in public()}
    assert set(OF_OPTIONS) <= names
    assert {*NOT_CALLED, *METHODS_LEFT_OUT} <= names
    assert {name for name in (*PROBLEMS, *STUDY) if "." not in name} <= names


@pytest.mark.parametrize(("name", "value"), [pytest.param(*each, id=each[0]) for each in public()])
def test_every_constructor_lists_its_arguments_for_an_unknown_one(name, value):
    if isinstance(value, type) and name not in NOT_CALLED and (name, "options") not in LEFT_OUT:
        with pytest.raises(CallError, match=rf"no_such_argument: given to .*accepted: {value.__name__}\("):
            value(no_such_argument=1)
