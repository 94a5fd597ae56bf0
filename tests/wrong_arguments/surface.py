"""The public surface: what can be called, its arguments, and the kind of each."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import jtik
from jtik import plotting
from jtik.interop.mujoco_model import to_mujoco
from jtik.interop.urdf import to_urdf
from jtik.planner import Planner
from jtik.problems import Case, ProblemSet
from jtik.qp import Conic, PersistentOSQP, QPSolversBackend, backend_of
from jtik.robot import DHRow, Mass, Mesh, Mimic
from jtik_formulations import FrameProximity, JointCentering, ObstacleAvoidance

from .values import (
    CONFIGURATION,
    COUNT,
    FLAG,
    NAME,
    NON_NEGATIVE,
    NOTHING,
    NUMBER,
    POSITIVE,
    POSITIVE_COUNT,
    POSITIVE_OR_INFINITE,
    SHARE,
    TEXT,
    Kind,
)


class Entry(NamedTuple):
    """One callable of the public surface.

    Attributes:
        call: the callable, with keyword arguments only.
        given: arguments with which a call succeeds, made anew for each call.
        kinds: the kind of each argument.
    """

    call: Callable[..., Any]
    given: Callable[[], Mapping[str, Any]]
    kinds: Mapping[str, Kind]


ARM = jtik.Robot.planar(2)
SPATIAL = jtik.Robot.builtin("ur5e")
MISSING = Path("/a folder that does not exist")
FIELD = (jtik.Circle((1.5, 0.0), 0.1),)
OBSTACLES = Kind(frozenset({"[]"}))
OPTIONAL_Q = CONFIGURATION | "None"
ONE_EACH = _limits = NUMBER | ("inf", "nan")


MJCF = '<mujoco><worldbody><body name="b"><joint name="j"/><geom size="1"/></body></worldbody></mujoco>'


def compiled_model() -> Any:
    import mujoco

    return mujoco.MjModel.from_xml_string(MJCF)


def nothing() -> dict[str, Any]:
    return {}


def solver() -> jtik.InverseKinematics:
    return jtik.InverseKinematics(
        ARM, jtik.FrameTask(), strategy="newton", criteria=JointCentering() + ObstacleAvoidance(FIELD)
    )


IK = solver()


def between(call: Callable[..., Any]) -> Callable[..., Any]:
    """The call after another one with other options, so that none of them is known from the call before."""

    def called(**arguments: Any) -> Any:
        IK.solve((1.0, 0.5), max_iterations=7, position_tolerance=1e-3)
        return call(**arguments)

    return called


def assign(name: str) -> Callable[..., Any]:
    def assigned(value: Any) -> None:
        IK.parameters[name] = value

    return assigned


def fixed(**given: Any) -> Callable[[], Mapping[str, Any]]:
    return lambda: dict(given)


TOLERANCES = {
    "position_tolerance": POSITIVE,
    "orientation_tolerance": POSITIVE,
    "optimality_tolerance": POSITIVE,
    "until": NOTHING,
    "max_iterations": COUNT,
}
STIFFNESS = POSITIVE
TASK = {"stiffness": STIFFNESS, "priority": COUNT, "name": NAME | "None"}
AXES = NAME | ("None", "text array")
SOLID = {"radius": POSITIVE}
JOINTS = NOTHING | "None"
SENTENCES = Kind(frozenset({"'x'", "''", "[]", "text array"}))
LENGTH_OR_ONE_EACH = NUMBER | "inf"
PAIRS = Kind(frozenset({"[]"}))

ROBOT: dict[str, Entry] = {
    "Robot": Entry(
        jtik.Robot,
        lambda: {"joints": ARM.joints},
        {
            "joints": Kind(frozenset({"[]"})),
            "name": TEXT,
            "planar": FLAG,
            "base": NOTHING,
            "tip": NOTHING | "None",
            "masses": CONFIGURATION | "None",
            "shapes": CONFIGURATION | "None",
            "meshes": CONFIGURATION | "None",
            "keyframes": CONFIGURATION | "None",
            "neutral": OPTIONAL_Q,
            "ignored": SENTENCES,
            "disabled_collisions": CONFIGURATION | "None",
        },
    ),
    "Robot.planar": Entry(
        jtik.Robot.planar,
        fixed(links=2),
        {
            "links": POSITIVE_COUNT,
            "lower": Kind(frozenset({"-1", "0", "0.5", "1.5", "2"})),
            "upper": LENGTH_OR_ONE_EACH,
            "velocity_limit": POSITIVE_OR_INFINITE,
            "name": TEXT | "None",
        },
    ),
    "Robot.vehicle": Entry(
        jtik.Robot.vehicle,
        fixed(links=2),
        {
            "links": POSITIVE_COUNT,
            "heading": FLAG,
            "lower": NUMBER,
            "upper": LENGTH_OR_ONE_EACH,
            "velocity_limit": POSITIVE_OR_INFINITE,
            "vehicle_lower": NUMBER,
            "vehicle_upper": LENGTH_OR_ONE_EACH,
            "vehicle_velocity_limit": POSITIVE_OR_INFINITE,
            "name": TEXT | "None",
        },
    ),
    "Robot.from_dh": Entry(
        jtik.Robot.from_dh,
        fixed(rows=[(1.0, 0.0, 0.0, 0.0)]),
        {"rows": NOTHING, "convention": NOTHING, "base": NOTHING | "None", "tool": NOTHING | "None", "name": TEXT},
    ),
    "Robot.from_urdf": Entry(
        jtik.Robot.from_urdf,
        fixed(
            path_or_xml='<robot name="a"><link name="b"/><link name="c"/><joint name="j" type="continuous">'
            '<parent link="b"/><child link="c"/></joint></robot>'
        ),
        {
            "path_or_xml": NOTHING,
            "tip": NOTHING | "None",
            "name": TEXT | "None",
            "free_base": FLAG,
            "planar_base": FLAG,
            "xacro_arguments": NOTHING | ("None", "{}"),
            "srdf": NOTHING | "None",
        },
    ),
    "Robot.from_mjcf": Entry(
        jtik.Robot.from_mjcf,
        fixed(path_or_xml=MJCF),
        {"path_or_xml": NOTHING, "tip": NOTHING | "None", "name": TEXT | "None"},
    ),
    "Robot.from_mujoco": Entry(
        jtik.Robot.from_mujoco,
        lambda: {"model": compiled_model()},
        {"model": NOTHING, "tip": NOTHING | "None", "name": TEXT | "None"},
    ),
    "Robot.builtin": Entry(jtik.Robot.builtin, nothing, {"name": NOTHING}),
    "Robot.collision_pairs": Entry(
        ARM.collision_pairs,
        nothing,
        {
            **dict.fromkeys(("exclude", "include"), PAIRS),
            "bodies": NOTHING | "None",
            "radius": NON_NEGATIVE,
            "within": NON_NEGATIVE,
        },
    ),
    "Robot.subset": Entry(ARM.subset, fixed(joints=["joint1"]), {"joints": NOTHING, "at": OPTIONAL_Q}),
    "Robot.with_tool": Entry(
        SPATIAL.with_tool,
        lambda: {"pose": np.eye(4)},
        {
            "pose": NOTHING,
            "name": NAME,
            "mass": NON_NEGATIVE | "None",
            "shapes": Kind(frozenset({"[]"})),
            "frame": NOTHING | "None",
        },
    ),
    "Robot.with_masses": Entry(SPATIAL.with_masses, nothing, {"masses": Kind(frozenset({"{}"}))}),
    "Robot.with_base": Entry(SPATIAL.with_base, lambda: {"pose": np.eye(4)}, {"pose": NOTHING, "name": NAME}),
    "Robot.at": Entry(ARM.at, nothing, {"q": NOTHING}),
    **{
        f"Robot.{name}": Entry(getattr(ARM, name), fixed(q=[0.1, 0.2]), {"q": CONFIGURATION, "frame": NOTHING | "None"})
        for name in ("pose", "position")
    },
    "Robot.jacobian": Entry(
        ARM.jacobian,
        fixed(q=[0.1, 0.2]),
        {"q": CONFIGURATION, "frame": NOTHING | "None", "rows": NOTHING | "None"},
    ),
    **{
        f"Robot.{name}": Entry(getattr(ARM, name), nothing, {"q": CONFIGURATION})
        for name in ("tangent", "full_configuration", "reduced")
    },
    "Robot.center_of_mass": Entry(SPATIAL.center_of_mass, nothing, {"q": CONFIGURATION}),
    "Robot.mass_matrix": Entry(SPATIAL.mass_matrix, nothing, {"q": CONFIGURATION}),
    "Robot.gravity_torque": Entry(
        SPATIAL.gravity_torque, fixed(q=SPATIAL.home), {"q": CONFIGURATION, "gravity": NOTHING | "None"}
    ),
    "Robot.configuration": Entry(ARM.configuration, nothing, {"q": CONFIGURATION}),
    "Robot.integrate": Entry(ARM.integrate, fixed(q=[0.1, 0.2], dq=[0.1, 0.2]), {"q": CONFIGURATION, "dq": NOTHING}),
    "Robot.difference": Entry(
        ARM.difference, fixed(start=[0.1, 0.2], end=[0.1, 0.2]), {"start": CONFIGURATION, "end": CONFIGURATION}
    ),
    "Robot.frame": Entry(ARM.frame, nothing, {"frame": NOTHING | "None"}),
    "Robot.path": Entry(ARM.path, nothing, {"frame": NOTHING | "None"}),
    "Robot.q_slice": Entry(ARM.q_slice, nothing, {"joint": NOTHING}),
    "Robot.v_slice": Entry(ARM.v_slice, nothing, {"joint": NOTHING}),
    "Robot.random_configuration": Entry(ARM.random_configuration, nothing, {"rng": COUNT}),
    "Robot.joint_values": Entry(
        ARM.joint_values, fixed(values=[0.1, 0.2], default=0.0), {"values": NUMBER | "{}", "default": NUMBER}
    ),
    "Robot.velocity_values": Entry(
        ARM.velocity_values, fixed(values=[0.1, 0.2], default=0.0), {"values": CONFIGURATION, "default": NUMBER}
    ),
    "Joint": Entry(
        jtik.Joint,
        fixed(name="a", type=jtik.JointType.REVOLUTE, parent="b", child="c"),
        {
            "name": TEXT,
            "type": NOTHING,
            "parent": TEXT,
            "child": TEXT,
            "origin": NOTHING,
            "axis": NOTHING,
            "lower": NUMBER,
            "upper": LENGTH_OR_ONE_EACH,
            "velocity_limit": POSITIVE_OR_INFINITE,
            "effort_limit": POSITIVE_OR_INFINITE,
            "mimic": NOTHING | "None",
        },
    ),
    "Mimic": Entry(
        Mimic,
        fixed(joint="a"),
        {"joint": TEXT, "multiplier": Kind(NUMBER.accepted - {"0"}), "offset": NUMBER},
    ),
    "Mesh": Entry(Mesh, fixed(file="a.stl"), {"file": NAME, "pose": NOTHING, "scale": NOTHING}),
    "Mass": Entry(Mass, fixed(mass=1.0), {"mass": NON_NEGATIVE, "center": NOTHING, "inertia": NOTHING}),
    "DHRow": Entry(
        DHRow,
        fixed(a=1.0, alpha=0.0),
        {
            "a": NUMBER,
            "alpha": NUMBER,
            "d": NUMBER,
            "theta": NUMBER,
            "joint": NOTHING,
            "lower": NUMBER,
            "upper": LENGTH_OR_ONE_EACH,
            "velocity_limit": POSITIVE_OR_INFINITE,
        },
    ),
}

TASKS: dict[str, Entry] = {
    "FrameTask": Entry(
        jtik.FrameTask, nothing, {"frame": NAME, "kind": NOTHING, "axes": AXES, "error": NOTHING, **TASK}
    ),
    "RelativeFrameTask": Entry(
        jtik.RelativeFrameTask,
        fixed(frame="a", reference="b"),
        {"frame": NAME, "reference": NAME, "kind": NOTHING, "axes": AXES, "error": NOTHING, **TASK},
    ),
    "AxisTask": Entry(jtik.AxisTask, nothing, {"frame": NAME, "axis": NOTHING, **TASK}),
    "LookAtTask": Entry(jtik.LookAtTask, nothing, {"frame": NAME, "axis": NOTHING, **TASK}),
    "CenterOfMassTask": Entry(jtik.CenterOfMassTask, nothing, {"axes": AXES, **TASK, "name": NAME}),
}

SOLIDS: dict[str, Entry] = {
    "Point": Entry(jtik.Point, nothing, {"center": NOTHING}),
    "Circle": Entry(jtik.Circle, fixed(center=(1.0, 0.0)), {"center": NOTHING, "radius": NON_NEGATIVE}),
    "Sphere": Entry(jtik.Sphere, fixed(center=(1.0, 0.0, 0.0)), {"center": NOTHING, "radius": NON_NEGATIVE}),
    **{
        kind.__name__: Entry(
            kind,
            fixed(start=(0.0, 0.0, 0.0), end=(1.0, 0.0, 0.0), radius=0.1),
            {"start": NOTHING, "end": NOTHING, "radius": POSITIVE},
        )
        for kind in (jtik.Capsule, jtik.Cylinder)
    },
    "Box": Entry(jtik.Box, fixed(pose=np.eye(4), half=(1.0, 1.0, 1.0)), {"pose": NOTHING, "half": NOTHING}),
    "HalfSpace": Entry(
        jtik.HalfSpace, fixed(point=(0.0, 0.0, 0.0), normal=(0.0, 0.0, 1.0)), {"point": NOTHING, "normal": NOTHING}
    ),
    "Polygon": Entry(jtik.Polygon, fixed(vertices=((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))), {"vertices": NOTHING}),
    "Scene": Entry(
        jtik.Scene, lambda: {"obstacles": FIELD}, {"obstacles": OBSTACLES | "{}", "gains": NOTHING | ("None", "{}")}
    ),
}

OF_OBSTACLES = {
    "obstacles": OBSTACLES,
    "gain": NON_NEGATIVE,
    "bodies": NOTHING,
    "capacity": POSITIVE_COUNT | "None",
    "name": NAME,
}
"""The options of the criteria on distances to obstacles."""

CONSTRAINTS: dict[str, Entry] = {
    "Limits": Entry(
        jtik.Limits,
        nothing,
        {
            "position": FLAG,
            "position_gain": SHARE,
            "velocity": POSITIVE_OR_INFINITE | "True",
            "acceleration": POSITIVE_OR_INFINITE | "None",
        },
    ),
    "Clearance": Entry(
        jtik.Clearance,
        lambda: {"measure": ObstacleAvoidance(FIELD)},
        {
            "measure": NOTHING,
            "safe": Kind(frozenset({"0"})),
            "influence": POSITIVE_OR_INFINITE,
            "gain": SHARE,
            "margin": Kind(frozenset()),
            "restore": FLAG,
            "name": NAME,
        },
    ),
}

SOLVER: dict[str, Entry] = {
    "InverseKinematics": Entry(
        jtik.InverseKinematics,
        lambda: {"robot": ARM, "task": jtik.FrameTask(), "strategy": "newton"},
        {
            "robot": NOTHING,
            "task": NOTHING,
            "criteria": Kind(frozenset({"None", "[]"})),
            "strategy": NOTHING,
            "solver": NOTHING | "None",
            "limits": FLAG,
            "clearances": Kind(frozenset({"None", "[]"})),
            "joints": JOINTS,
            "at": OPTIONAL_Q,
            "weights": CONFIGURATION | "None",
            "compiled": FLAG.without("True"),
            "null_space_rate": POSITIVE_OR_INFINITE,
            "progress": FLAG.without("True", "class"),
        },
    ),
    "InverseKinematics.warm_up": Entry(IK.warm_up, nothing, {"progress": FLAG.without("True", "class")}),
    "InverseKinematics.step": Entry(
        IK.step,
        fixed(q=[0.3, 0.2], target=(1.0, 1.0)),
        {"q": CONFIGURATION, "target": NOTHING, "dt": POSITIVE | "None"},
    ),
    "InverseKinematics.jog": Entry(
        IK.jog,
        fixed(q=[0.3, 0.2], rate=0.5),
        {"q": CONFIGURATION, "rate": NUMBER, "direction": Kind(frozenset({"0", "None"})), "dt": POSITIVE},
    ),
    "InverseKinematics.reset": Entry(
        IK.reset,
        fixed(velocity=[0.3, 0.2]),
        {"velocity": CONFIGURATION | "None"},
    ),
    "InverseKinematics.report": Entry(
        IK.report,
        fixed(q=[0.3, 0.2], target=(1.0, 1.0)),
        {"q": CONFIGURATION, "target": NOTHING},
    ),
    "Planner": Entry(
        Planner,
        lambda: {"robot": ARM, "criteria": None, "strategy": "newton", "folder": False},
        {
            "robot": NOTHING.without("None"),
            "task": Kind(frozenset({"None"})),
            "scene": OBSTACLES | ("{}", "None"),
            "strategy": NOTHING,
            "criteria": Kind(frozenset({"None", "[]"})),
            "q0": OPTIONAL_Q,
            "limits": FLAG,
            "weights": Kind(frozenset({"None", "{}"})),
            "safe": NON_NEGATIVE,
            "target_speed": Kind(frozenset({"None"})),
            "dt": POSITIVE,
            "compiled": FLAG.without("True"),
            "folder": NOTHING.without("None", "'x'", "bytes"),
            "clock": NOTHING.without("class"),
            "executor": Kind(frozenset({"None"})),
        },
    ),
    "InverseKinematics.step, arrays": Entry(
        lambda q, target: IK.step(np.array(q) if isinstance(q, list) else q, target),
        lambda: {"q": np.array([0.3, 0.2]), "target": np.array([1.0, 1.0])},
        {"q": CONFIGURATION.without("[]", "[1, 'a']", "[1.0, True]"), "target": NOTHING},
    ),
    "InverseKinematics.solve": Entry(
        between(IK.solve),
        fixed(target=(1.0, 1.0), restarts=1, position_tolerance=1e-3),
        {
            "target": NOTHING,
            "q0": OPTIONAL_Q,
            "restarts": COUNT,
            "seed": COUNT | "None",
            "best_of": POSITIVE_COUNT,
            "jump_limit": POSITIVE | "None",
            "trace": FLAG,
            "lanes": FLAG,
            "nearest": FLAG.without("True"),
            **TOLERANCES,
        },
    ),
    "InverseKinematics.solve[lanes]": Entry(
        between(IK.solve),
        fixed(target=(1.0, 1.0), restarts=1, position_tolerance=1e-3, lanes=True),
        {
            "target": NOTHING,
            "q0": OPTIONAL_Q,
            "restarts": COUNT.without("0"),
            "seed": COUNT | "None",
            "best_of": POSITIVE_COUNT.without("2"),
            "jump_limit": NOTHING | "None",
            "trace": FLAG.without("True"),
            "lanes": FLAG,
            "nearest": FLAG,
            **TOLERANCES,
        },
    ),
    "InverseKinematics.solve_batch": Entry(
        between(IK.solve_batch),
        fixed(targets=[(1.0, 1.0), (1.0, 0.5)], restarts=1, position_tolerance=1e-3),
        {
            "targets": Kind(frozenset({"[]"})),
            "q0": OPTIONAL_Q,
            "restarts": COUNT,
            "seed": COUNT | "None",
            "progress": FLAG.without("True", "class"),
            "executor": NOTHING | "None",
            "block": POSITIVE_COUNT,
            "threads": POSITIVE_COUNT,
            "lanes": FLAG,
            "save": NOTHING | "None",
            **TOLERANCES,
        },
    ),
    "InverseKinematics.track": Entry(
        between(IK.track),
        fixed(targets=[(1.0, 1.0), (1.0, 0.9)], position_tolerance=1e-3),
        {
            "targets": NOTHING,
            "q0": OPTIONAL_Q,
            "dt": POSITIVE,
            "progress": FLAG.without("True", "class"),
            **TOLERANCES,
        },
    ),
    "InverseKinematics.build": Entry(
        jtik.InverseKinematics(ARM, jtik.FrameTask(), criteria=JointCentering(), strategy="newton+qp").build,
        fixed(q=[0.3, 0.2], target=(1.0, 1.0)),
        {"q": CONFIGURATION, "target": NOTHING, "qp": NOTHING | "None"},
    ),
    "InverseKinematics.full_configuration": Entry(IK.full_configuration, nothing, {"q": CONFIGURATION}),
    "InverseKinematics.reduced": Entry(IK.reduced, nothing, {"q": CONFIGURATION}),
    "parameters[weight]": Entry(assign("joint_centering.weight"), nothing, {"value": NUMBER}),
    "parameters[stiffness]": Entry(assign("joint_centering.stiffness"), nothing, {"value": NON_NEGATIVE | "{}"}),
    "parameters[preferred]": Entry(assign("joint_centering.preferred"), nothing, {"value": NUMBER | "{}"}),
    "parameters[gain]": Entry(assign("obstacle_avoidance.gain"), nothing, {"value": NON_NEGATIVE}),
    "parameters[centers]": Entry(assign("obstacle_avoidance.centers"), nothing, {"value": NUMBER}),
    "parameters[radii]": Entry(assign("obstacle_avoidance.radii"), nothing, {"value": NON_NEGATIVE}),
}

CRITERIA: dict[str, Entry] = {
    "criterion * weight": Entry(lambda weight: JointCentering() * weight, nothing, {"weight": NUMBER}),
    "criterion / divisor": Entry(
        lambda divisor: JointCentering() / divisor, nothing, {"divisor": Kind(NUMBER.accepted - {"0"})}
    ),
    "CriterionSum.of": Entry(jtik.CriterionSum.of, nothing, {"criteria": Kind(frozenset({"None", "[]"}))}),
    "CriterionSum": Entry(jtik.CriterionSum, nothing, {"terms": Kind(frozenset({"[]"}))}),
    "Criterion.__call__": Entry(
        JointCentering(), fixed(q=[0.1, 0.2], robot=ARM), {"q": CONFIGURATION, "robot": NOTHING}
    ),
    "Criterion.gradient": Entry(
        JointCentering().gradient, fixed(q=[0.1, 0.2], robot=ARM), {"q": CONFIGURATION, "robot": NOTHING}
    ),
    "criterion": Entry(
        jtik.criterion,
        nothing,
        {
            "function": NOTHING | "None",
            "residual": FLAG,
            "numeric": FLAG,
            "gradient": NOTHING | "None",
            "step": POSITIVE,
        },
    ),
    "criterion, numeric": Entry(
        jtik.criterion,
        fixed(numeric=True),
        {"function": NOTHING | "None", "residual": NOTHING, "gradient": NOTHING | "None", "step": POSITIVE},
    ),
    "criterion, with options": Entry(
        lambda function: jtik.criterion(residual=True)(function), nothing, {"function": NOTHING}
    ),
    "citations": Entry(jtik.citations, nothing, {"of": NOTHING}),
    **{
        f"frame_proximity({place})": Entry(FrameProximity, nothing, {place: NOTHING})
        for place in ("point", "line", "plane")
    },
    "register_criterion": Entry(jtik.register_criterion, nothing, {"name": NAME}),
    "register_strategy": Entry(jtik.register_strategy, nothing, {"name": NAME}),
    "register_secondary": Entry(jtik.register_secondary, nothing, {"name": NAME}),
    "register_criterion(class)": Entry(
        jtik.register_criterion("a name of the table of wrong arguments"), nothing, {"plugin": NOTHING}
    ),
}

SECONDARY = NOTHING
GAINED = {"gain": SHARE, "lm_damping": NON_NEGATIVE, "damping": POSITIVE}
SCALED = {"q_limit": POSITIVE_OR_INFINITE, "backtracking": FLAG, "secondary": NOTHING}
FINITE_Q_LIMIT = {"q_limit": POSITIVE}
FRAME = NAME | "None"
OF_RANGES = {
    "lower": NUMBER | ("None", "{}"),
    "upper": NUMBER | ("None", "{}"),
    "weights": NON_NEGATIVE | ("None", "{}"),
    "name": NAME,
}
OF_ROWS = {
    "frame": FRAME,
    "kind": NOTHING,
    "axes": AXES,
    "length": POSITIVE | "None",
    "damping": POSITIVE,
    "name": NAME,
}
OF_SIGHT = {"target": NOTHING, "frame": FRAME, "axis": NOTHING | "None", "floor": POSITIVE, "name": NAME}
OF_OPTIONS: dict[str, dict[str, Kind]] = {
    "damped": {**SCALED, "damping": POSITIVE, "explore": FLAG},
    "damped_constant": {**SCALED, "damping": POSITIVE},
    "hybrid": {**FINITE_Q_LIMIT, "secondary": NOTHING, "explore": FLAG},
    "jparse": {**SCALED, "threshold": SHARE, "singular_gain": POSITIVE},
    "lexicographic_qp": {**SCALED, "damping": NON_NEGATIVE},
    "mink": {
        "strict": FLAG,
        "weight": POSITIVE,
        "gain": SHARE,
        "lm_damping": NON_NEGATIVE,
        "damping": NON_NEGATIVE,
        "step_limit": POSITIVE_OR_INFINITE,
        "descent": NOTHING,
        "tasks": Kind(frozenset({"[]"})),
    },
    "nakamura": {**SCALED, "damping": POSITIVE, "threshold": SHARE},
    "newton": SCALED,
    "selectively_damped": {
        "clamp": NOTHING,
        "max_angle": POSITIVE,
        "max_length": POSITIVE_OR_INFINITE,
        "max_error": POSITIVE_OR_INFINITE,
        "effectors": NOTHING | "None",
        "backtracking": FLAG,
        "secondary": NOTHING,
    },
    "sns": {
        **SCALED,
        "gain": SHARE,
        "damping": NON_NEGATIVE,
        "rule": NOTHING,
        "rounds": POSITIVE_COUNT | "None",
    },
    "sns_qp": {**SCALED, "gain": SHARE, "damping": NON_NEGATIVE},
    "sugihara": {**SCALED, "bias": POSITIVE},
    "task_priority": {**SCALED, "rule": NOTHING, "damping": NON_NEGATIVE},
    "transpose": {**SCALED, "rule": NOTHING},
    "transpose_bb": {**FINITE_Q_LIMIT, "monotone": FLAG, "memory": POSITIVE_COUNT, "secondary": NOTHING},
    "weighted_least_norm": {**SCALED, "max_weight": Kind(frozenset({"1.5", "2"}))},
    "weighted_qp": {
        "gain": SHARE,
        "lm_damping": NON_NEGATIVE,
        "damping": POSITIVE,
        "weight": POSITIVE,
        "curvature": POSITIVE,
        "q_limit": POSITIVE_OR_INFINITE,
        "backtracking": FLAG,
    },
    "gradient": {"rule": NOTHING, "step_limit": POSITIVE, "beta_max": POSITIVE, "floor": NON_NEGATIVE},
    "qp": {"rule": NOTHING, "step_limit": POSITIVE, "beta_max": POSITIVE, "floor": NON_NEGATIVE, "weight": POSITIVE},
    "second_order": {"curvature": NOTHING, "step_limit": POSITIVE, "corrections": COUNT},
    "joint_centering": {
        "stiffness": NON_NEGATIVE | "{}",
        "preferred": OPTIONAL_Q,
        "name": NAME,
    },
    "gravity_torque": {"scale": POSITIVE | "{}" | "None", "gravity": NOTHING | "None", "name": NAME},
    "kinetic_energy": {"reference": NOTHING | "None" | "{}", "rotor_inertia": NON_NEGATIVE | "{}", "name": NAME},
    "effective_mass": {"direction": NOTHING, "frame": FRAME, "rotor_inertia": NON_NEGATIVE | "{}", "name": NAME},
    "support_polygon": {"vertices": NOTHING, "margin": POSITIVE, "frame": FRAME, "name": NAME},
    "obstacle_avoidance": {**OF_OBSTACLES, "floor": POSITIVE},
    "khatib_potential": {**OF_OBSTACLES, "influence": POSITIVE, "floor": Kind(frozenset())},
    "obstacle_barrier": {**OF_OBSTACLES, "influence": POSITIVE, "floor": SHARE},
    "soft_clearance": {**OF_OBSTACLES, "smoothing": POSITIVE},
    "compact_posture": {"center": NOTHING | "None", "name": NAME},
    "directional_manipulability": {"direction": NOTHING | "None", **OF_ROWS, "measure": NOTHING},
    "frame_proximity": {
        "frame": FRAME,
        **dict.fromkeys(("point", "line", "plane"), NOTHING | "None"),  # beside the height they are one too many
        "height": NUMBER,
        "name": NAME,
    },
    "isotropy": OF_ROWS,
    "limit_activation": {**OF_RANGES, "start": SHARE},
    "limit_barrier": {**OF_RANGES, "margin": SHARE},
    "limit_centering": OF_RANGES,
    "limit_norm": {**OF_RANGES, "power": Kind(frozenset({"2"}))},
    "look_at": OF_SIGHT,
    "manipulability": {**OF_ROWS, "measure": NOTHING},
    "minimum_displacement": {"reference": OPTIONAL_Q, "stiffness": NON_NEGATIVE | "{}", "name": NAME},
    "self_collision": {
        **dict.fromkeys(("exclude", "include"), PAIRS | ("text array", "['x']")),
        "gain": NON_NEGATIVE,
        "influence": POSITIVE,
        "bodies": NOTHING | "None",
        "radius": NON_NEGATIVE,
        "within": NON_NEGATIVE,
        "name": NAME,
    },
    "smallest_singular_value": OF_ROWS,
    "swivel_angle": {
        **dict.fromkeys(("shoulder", "elbow", "wrist"), NAME),
        "angle": NUMBER,
        "reference": NOTHING,
        "floor": POSITIVE,
        "name": NAME,
    },
    "visibility": {**OF_SIGHT, "half_angle": POSITIVE},
}
"""The options of what is registered, by its name."""

NEEDED: dict[str, dict[str, Any]] = {
    "obstacle_avoidance": {"obstacles": FIELD},
    "khatib_potential": {"obstacles": FIELD},
    "obstacle_barrier": {"obstacles": FIELD},
    "soft_clearance": {"obstacles": FIELD},
    "frame_proximity": {"height": 0.4},
    "effective_mass": {"direction": (1.0, 0.5)},
    "support_polygon": {"vertices": [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)]},
    "look_at": {"target": (1.0, 0.5)},
    "swivel_angle": {"shoulder": "base", "elbow": "link2", "wrist": "tip"},
    "visibility": {"target": (1.0, 0.5)},
}


def of_registered() -> dict[str, Entry]:
    """One entry for each registered class."""
    return {
        name: Entry(registry[name], fixed(**NEEDED.get(name, {})), OF_OPTIONS[name])
        for registry in (jtik.strategies, jtik.secondaries, jtik.criteria)
        for name in OF_OPTIONS
        if name in registry
    }


SMALL = ProblemSet("small", (Case(name="one", kind="own", q0=[0.3, 0.2], targets=[(1.0, 1.0)]),))
SCENE = Case(
    name="scene",
    kind="scene",
    q0=[0.3, 0.2],
    targets=[(1.0, 1.0)],
    parameters={"obstacle_avoidance.centers": [[1.5, 0.0]], "obstacle_avoidance.radii": [0.1]},
)
DRAWN = {"robot": NOTHING, "task": NOTHING, "count": POSITIVE_COUNT, "seed": COUNT, "joints": JOINTS, "at": OPTIONAL_Q}
STARTED = {**DRAWN, "q0": OPTIONAL_Q}
ON_PATH = {**STARTED, "dt": POSITIVE}


FITS = (NOTHING | "None").without("0.5", "1.5", "2")
"""A size, which may be too large for the arm."""


def drawn(generator: Callable[..., Any], **kinds: Kind) -> Entry:
    return Entry(generator, lambda: {"robot": ARM, "task": jtik.FrameTask(), "count": 1}, kinds)


PROBLEMS: dict[str, Entry] = {
    "reachable": drawn(jtik.problems.reachable, **STARTED),
    "near_singular": drawn(jtik.problems.near_singular, **DRAWN, start_distance=NOTHING, target_distance=NOTHING),
    "boundary": drawn(jtik.problems.boundary, **STARTED, share=SHARE),
    "unreachable": drawn(jtik.problems.unreachable, **STARTED, beyond=NOTHING),
    "near_limits": Entry(
        jtik.problems.near_limits,
        lambda: {"robot": jtik.Robot.planar(2, lower=-2, upper=2), "task": jtik.FrameTask(), "count": 1},
        {**STARTED, "share": SHARE},
    ),
    "circle": drawn(jtik.problems.circle, **ON_PATH, radius=FITS, points=POSITIVE_COUNT),
    "line": drawn(jtik.problems.line, **ON_PATH, length=FITS, back=FLAG, points=POSITIVE_COUNT),
    "lissajous": drawn(
        jtik.problems.lissajous,
        **{**ON_PATH, "q0": OPTIONAL_Q.without("{}")},
        amplitude=FITS,
        points=POSITIVE_COUNT,
        frequencies=NOTHING,
    ),
    "path": Entry(
        jtik.problems.path,
        lambda: {"robot": ARM, "task": jtik.FrameTask(), "targets": [(1.0, 1.0), (1.0, 0.9)]},
        {
            "robot": NOTHING,
            "task": NOTHING,
            "targets": NOTHING,
            "q0": OPTIONAL_Q,
            "dt": POSITIVE | "None",
            "name": NAME,
            "joints": JOINTS,
            "at": OPTIONAL_Q,
            "parameters": CONFIGURATION | "None",
            "origin": TEXT,
        },
    ),
    "scene": drawn(
        jtik.problems.scene,
        **STARTED,
        obstacles=POSITIVE_COUNT,
        radius=NOTHING,
        clearance=(NOTHING | "0").without("0.5", "1.5", "2"),
        shapes=NOTHING,
        criteria=NAME | "text array",
    ),
    "five_families": Entry(jtik.problems.five_families, nothing, {"count": POSITIVE_COUNT.without("2")}),
    "named": Entry(jtik.problems.named, nothing, {"name": NOTHING}),
    "Case": Entry(
        Case,
        fixed(name="one", kind="own", q0=[0.3, 0.2], targets=[(1.0, 1.0)]),
        {
            "name": NAME,
            "kind": NAME,
            "q0": Kind(frozenset({"[]"})),
            "targets": Kind(frozenset({"(3, 5)", "generator"})),
            "dt": POSITIVE | "None",
            "closed": NOTHING,
            "parameters": CONFIGURATION,
            "reachable": FLAG | "None",
            "known": CONFIGURATION,
            "origin": TEXT,
        },
    ),
    "ProblemSet": Entry(
        ProblemSet,
        fixed(name="set", cases=SMALL.cases),
        {"name": NAME, "cases": Kind(frozenset({"[]"})), "seed": COUNT | "None", "origin": TEXT},
    ),
    "obstacles_of": Entry(jtik.problems.obstacles_of, lambda: {"case": SCENE}, {"case": NOTHING, "criterion": NOTHING}),
}

STUDY: dict[str, Entry] = {
    "compare": Entry(
        jtik.compare,
        lambda: {
            "robot": ARM,
            "task": jtik.FrameTask(),
            "strategies": "newton",
            "problems": SMALL,
            "repeats": 1,
            "traces": 0,
        },
        {
            "robot": NOTHING,
            "task": NOTHING,
            "strategies": NAME | "text array",
            "criteria": Kind(frozenset({"None", "[]"})),
            "problems": NOTHING,
            "count": POSITIVE_COUNT,
            "seed": COUNT,
            "restarts": COUNT,
            "limits": FLAG,
            "clearances": Kind(frozenset({"None", "[]"})),
            "joints": JOINTS,
            "at": OPTIONAL_Q,
            "compiled": FLAG.without("True"),
            "repeats": POSITIVE_COUNT,
            "traces": COUNT,
            "executor": NOTHING | "None",
            "block": POSITIVE_COUNT,
            "save": NOTHING | "None",
            "progress": FLAG.without("True", "class"),
            **TOLERANCES,
        },
    ),
    "StrategyContender": Entry(
        jtik.study.StrategyContender,
        fixed(strategy="newton"),
        {"strategy": NAME, "solver": NAME | "None", "compiled": FLAG | "None", "label": NAME | "None"},
    ),
    "Comparison.load": Entry(jtik.study.Comparison.load, nothing, {"path": NOTHING}),
    "Trajectory.load": Entry(jtik.Trajectory.load, nothing, {"path": NOTHING}),
}

PLOTTED = {"robot": ARM, "configurations": [[0.3, 0.2]]}
TRAJECTORY = IK.track([(1.0, 0.5), (1.0, 0.6)])
TRACE = IK.solve((1.0, 0.5), q0=[0.3, 0.9], trace=True).trace


def viewed(**options: Any) -> None:
    """A view of an arm, which is closed at once."""
    arguments = {"subjects": [0.3, 0.2], **options}
    jtik.view(ARM, arguments.pop("subjects"), **arguments).close()


VIEWER: dict[str, Entry] = {
    "view": Entry(
        viewed,
        nothing,
        {
            "subjects": CONFIGURATION,
            "robot": NOTHING | "None",
            "obstacles": Kind(frozenset({"[]"})),
            "labels": NAME | "None",
            "show": NOTHING,
            "port": NOTHING | "None",
            "height": POSITIVE_COUNT,
        },
    )
}


def axes() -> Any:
    return plotting.blank_figure((-2.0, 2.0, -2.0, 2.0), 4.0)[1]


PLOTTING: dict[str, Entry] = {
    "posture_figure": Entry(
        plotting.posture_figure,
        fixed(**PLOTTED, width=4.0),
        {
            "robot": NOTHING,
            "configurations": CONFIGURATION,
            "obstacles": OBSTACLES,
            "path": NOTHING | "None",
            "window": NOTHING | "None",
            "width": POSITIVE | "None",
            "view": NOTHING,
            "show": NOTHING | "None",
        },
    ),
    "Robot.plot": Entry(ARM.plot, nothing, {"q": OPTIONAL_Q}),
    "trajectory_figure": Entry(
        plotting.trajectory_figure, lambda: {"trajectory": TRAJECTORY}, {"trajectory": NOTHING, "width": POSITIVE}
    ),
    "trace_figure": Entry(plotting.trace_figure, lambda: {"trace": TRACE}, {"trace": NOTHING, "width": POSITIVE}),
    "write_motion": Entry(
        plotting.write_motion,
        lambda: {"path": MISSING / "a.gif", "robot": ARM, "trajectory": [[0.3, 0.2]]},
        {
            "path": NOTHING,
            "robot": NOTHING,
            "trajectory": CONFIGURATION.without("{}"),
            "obstacles": OBSTACLES.without("[]"),
            "speed": POSITIVE.without(*POSITIVE.accepted),
            "rate": POSITIVE.without(*POSITIVE.accepted),
            "width": POSITIVE.without(*POSITIVE.accepted),
            "view": NOTHING,
            "show": NOTHING,
        },
    ),
    "draw_postures": Entry(
        plotting.draw_postures,
        lambda: {"axes": axes(), **PLOTTED},
        {"robot": NOTHING, "configurations": NOTHING, "colormap": NOTHING, "width": POSITIVE},
    ),
    "DrawnArm": Entry(plotting.DrawnArm, lambda: {"axes": axes(), "robot": ARM}, {"robot": NOTHING, "width": POSITIVE}),
    "Skeleton": Entry(plotting.Skeleton, nothing, {"robot": NOTHING}),
    "draw_base": Entry(plotting.draw_base, lambda: {"axes": axes()}, {"position": NOTHING, "size": POSITIVE}),
    "draw_obstacles": Entry(plotting.draw_obstacles, lambda: {"axes": axes()}, {"obstacles": OBSTACLES}),
    "draw_path": Entry(plotting.draw_path, lambda: {"axes": axes()}, {"points": NOTHING}),
    "blank_figure": Entry(
        plotting.blank_figure, fixed(window=(0.0, 1.0, 0.0, 1.0), width=4.0), {"window": NOTHING, "width": POSITIVE}
    ),
    "new_figure": Entry(plotting.new_figure, fixed(size=(2.0, 2.0)), {"size": NOTHING}),
    "shades": Entry(plotting.shades, fixed(count=2), {"count": COUNT, "colormap": NOTHING}),
    "window_around": Entry(
        plotting.window_around,
        fixed(points=[[0.0, 1.0], [1.0, 0.0]]),
        {"points": NOTHING, "obstacles": OBSTACLES, "margin": NON_NEGATIVE},
    ),
    "write_animation": Entry(
        plotting.write_animation,
        lambda: {"path": MISSING / "a.gif", "figure": None, "draw": print, "frames": 2},
        {
            "path": NOTHING.without("'x'"),
            "draw": NOTHING.without("class"),
            "frames": POSITIVE_COUNT.without("2"),
            "seconds": POSITIVE.without(*POSITIVE.accepted),
            "hold": POSITIVE.without(*POSITIVE.accepted),
        },
    ),
}

TESTING: dict[str, Entry] = {
    "check_criterion": Entry(
        jtik.testing.check_criterion,
        lambda: {"criterion": JointCentering(), "robot": ARM, "samples": 1},
        {"robot": NOTHING, "samples": COUNT | "[]", "rng": COUNT},
    ),
    "check_strategy": Entry(
        jtik.testing.check_strategy,
        fixed(strategy="newton"),
        {
            "strategy": NOTHING,
            "samples": POSITIVE_COUNT.without("2"),
            "rng": COUNT.without("0", "2"),
            "monotone": (FLAG | "None").without("True", "None"),
            "tolerance": POSITIVE.without(*POSITIVE.accepted),
            "max_iterations": POSITIVE_COUNT.without("2"),
        },
    ),
}

BACKENDS: dict[str, Entry] = {
    "Conic": Entry(Conic, nothing, {"name": NOTHING, "accuracy": POSITIVE | "None"}),
    "QPSolversBackend": Entry(QPSolversBackend, fixed(name="daqp"), {"name": NOTHING, "accuracy": POSITIVE | "None"}),
    "PersistentOSQP": Entry(PersistentOSQP, nothing, {"accuracy": POSITIVE | "None"}),
    "backend_of": Entry(backend_of, nothing, {"solver": NOTHING | "None"}),
}

INTEROP: dict[str, Entry] = {
    "to_urdf": Entry(
        to_urdf,
        fixed(robot=ARM),
        {"robot": NOTHING, "revolute_limit": POSITIVE | "None", "frame": NOTHING | "None"},
    ),
    "to_mujoco": Entry(to_mujoco, fixed(robot=SPATIAL), {"robot": NOTHING, "obstacles": OBSTACLES}),
}

ENTRIES: dict[str, Entry] = {
    **ROBOT,
    **TASKS,
    **SOLIDS,
    **CONSTRAINTS,
    **SOLVER,
    **CRITERIA,
    **of_registered(),
    **PROBLEMS,
    **STUDY,
    **PLOTTING,
    **VIEWER,
    **TESTING,
    **BACKENDS,
    **INTEROP,
}
