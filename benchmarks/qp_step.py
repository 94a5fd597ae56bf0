"""One differential step of a Panda: a pose task, a posture beside or below it, position and velocity limits, DAQP.

jtik's strategies beside mink, pink and placo, on one URDF, along one path of configurations and targets, in one process
and interleaved. Every answer is judged by MuJoCo: what the step leaves of the error, and whether limits hold.

    python benchmarks/qp_step.py [--compiled] [--path hurried] [--strategies newton+qp weighted_qp] [--cpu]

The peers are installed by

    python -m pip install mink pin-pink "placo==0.10.2"

which brings Pinocchio 3.8; a peer that is missing is left out, and said to be.
"""

from __future__ import annotations

import argparse
import gc
import json
import os
import pathlib
import platform
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from importlib import metadata
from typing import Any

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")  # matrices of seven rows gain nothing from threads, and mink loses by them

import mujoco  # noqa: E402
import numpy as np  # noqa: E402

import jtik  # noqa: E402
from jtik_formulations import JointCentering, WeightedQP  # noqa: E402

Array = np.ndarray
DT = 0.02
"""Time of a step [s]."""
PLACES = 50
"""Configurations on the path, each with the target that a joint motion of the speed of the path leads to."""
REPEATED = 50
"""Calls in a row of what is called alone."""
POSTURE_COST = 1e-2
"""Of the posture against 1 of the pose, where a library weighs the two."""
ACCURACY = 1e-6
"""How far beyond a limit [rad] a step may end."""
STRATEGIES = ("newton+qp", "hybrid+qp", "weighted_qp")
PACKAGES = ("numpy", "casadi", "daqp", "mink", "pin-pink", "pin", "placo", "mujoco")

Step = Callable[[Array, Array], Array]
"""(q, target (4, 4)) -> displacement (n,)."""

Clock = Callable[[], float]
"""Seconds."""


@dataclass(frozen=True)
class Row:
    """Figures of one way to step.

    Attributes: times [us]; the share of the pose error that is left after the step, median over the path; farthest
    beyond a position or velocity limit [rad]; the share of steps with a joint at a limit; why there are no figures.
    """

    name: str
    median: float = float("nan")
    p10: float = float("nan")
    p90: float = float("nan")
    left: float = float("nan")
    beyond: float = float("nan")
    active: float = float("nan")
    missing: str = ""


def urdf(robot: jtik.Robot) -> str:
    """Kinematics and limits as a URDF that all libraries read; masses are all alike."""
    inertial = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    links = "".join(f'<link name="{frame}">{inertial}</link>' for frame in robot.frame_names)
    joints = "".join(_joint(joint) for joint in robot.joints)
    return f'<robot name="{robot.name}">{links}{joints}</robot>'


def _joint(joint: jtik.Joint) -> str:
    R, p = joint.origin[:3, :3], joint.origin[:3, 3]
    rpy = (np.arctan2(R[2, 1], R[2, 2]), np.arcsin(np.clip(-R[2, 0], -1, 1)), np.arctan2(R[1, 0], R[0, 0]))
    xyz, turn, axis = (" ".join(repr(float(x)) for x in values) for values in (p, rpy, joint.axis))
    name = joint.name if joint.is_moving else f"{joint.name} mount"  # a frame of pink's must not be called like a joint
    kind = {"hinge": "revolute", "slide": "prismatic", "fixed": "fixed"}[joint.type.value]
    limit = ""
    if joint.is_moving:
        limit = (
            f'<limit lower="{joint.lower!r}" upper="{joint.upper!r}" velocity="{joint.velocity_limit!r}" effort="1"/>'
        )
    ends = f'<parent link="{joint.parent}"/><child link="{joint.child}"/>'
    return (
        f'<joint name="{name}" type="{kind}">{ends}<origin xyz="{xyz}" rpy="{turn}"/>'
        f'<axis xyz="{axis}"/>{limit}</joint>'
    )


@dataclass(frozen=True)
class Path:
    """Configurations (n,) each, and for each a target (4, 4) to step towards; the posture to prefer."""

    home: Array
    q: list[Array]
    targets: list[Array]

    @classmethod
    def tracked(cls, robot: jtik.Robot, home: Array) -> Path:
        """As a controller sees it: the tip goes round, the arm follows and has settled near its posture.

        Position and velocity limits hold, but few joints are at them. The arm follows by `hybrid`, as a judge that is
        none of the rows.
        """
        ik = jtik.InverseKinematics(robot, jtik.FrameTask(robot.tip, kind="pose"), criteria=JointCentering())
        ik.parameters["joint_centering.preferred"] = home
        lap = [robot.pose(q) for q in _curve(robot, home, PLACES)]
        q, seen = home, []
        for target in 3 * lap:
            seen.append(q)
            q = ik.track([target], q0=q, dt=DT, until="stationary", max_iterations=20).q[0]
        return cls(home, seen[-PLACES:], lap)

    @classmethod
    def hurried(cls, robot: jtik.Robot, home: Array) -> Path:
        """Everywhere about the posture: its pull is larger than the velocity limits allow, and they are active."""
        q = _curve(robot, home, PLACES)
        return cls(home, q, [robot.pose(ahead) for ahead in [*q[1:], q[0]]])


def _curve(robot: jtik.Robot, home: Array, count: int) -> list[Array]:
    """A closed curve about ``home``, as fast as half the velocity limits at most."""
    generator = np.random.default_rng(0)
    phase, widest = generator.uniform(0, 2 * np.pi, robot.n), 0.5 * DT * robot.velocity_limit * count / (2 * np.pi)
    reach = np.minimum(generator.uniform(0.2, 0.5, robot.n), widest)
    angle = np.linspace(0, 2 * np.pi, count, endpoint=False)
    return [np.clip(home + reach * np.sin(a + phase), robot.lower + 0.05, robot.upper - 0.05) for a in angle]


PATHS: dict[str, Callable[[jtik.Robot, Array], Path]] = {"tracked": Path.tracked, "hurried": Path.hurried}


def solver(robot: jtik.Robot, path: Path, strategy: str, *, compiled: bool) -> jtik.InverseKinematics:
    """The problem as jtik has it."""
    law = WeightedQP(weight=POSTURE_COST**2) if strategy == "weighted_qp" else strategy
    ik = jtik.InverseKinematics(
        robot, jtik.FrameTask(robot.tip, kind="pose"), criteria=JointCentering(), strategy=law, compiled=compiled
    )
    ik.parameters["joint_centering.preferred"] = path.home
    return ik


def stepping(ik: jtik.InverseKinematics) -> Step:
    """``ik.step`` as a controller calls it."""

    def step(q: Array, target: Array) -> Array:
        return ik.step(q, target, dt=DT).q - q

    return step


def minks(robot: jtik.Robot, path: Path) -> Step:
    """mink as its examples have it: limits given, everything else default."""
    import mink

    from jtik.interop.mink import to_mujoco, velocity_limit

    model = to_mujoco(robot)
    configuration = mink.Configuration(model)
    tip = mink.FrameTask(robot.tip, "body", position_cost=1.0, orientation_cost=1.0)
    posture = mink.PostureTask(model, cost=POSTURE_COST)
    posture.set_target(path.home)
    tasks, limits = [tip, posture], [mink.ConfigurationLimit(model), velocity_limit(robot, model)]

    def step(q: Array, target: Array) -> Array:
        configuration.update(q)
        tip.set_target(mink.SE3.from_matrix(target))
        return DT * mink.solve_ik(configuration=configuration, tasks=tasks, dt=DT, solver="daqp", limits=limits)

    return step


def pinks(robot: jtik.Robot, path: Path) -> Step:
    """pink as its examples have it: limits are its default."""
    import pink
    import pinocchio

    model = pinocchio.buildModelFromXML(urdf(robot))
    configuration = pink.Configuration(model, model.createData(), path.home.copy())
    tip = pink.tasks.FrameTask(robot.tip, position_cost=1.0, orientation_cost=1.0)
    posture = pink.tasks.PostureTask(cost=POSTURE_COST)
    posture.set_target(path.home.copy())
    tasks = [tip, posture]

    def step(q: Array, target: Array) -> Array:
        configuration.update(q)
        tip.set_target(pinocchio.SE3(target))
        return DT * pink.solve_ik(configuration=configuration, tasks=tasks, dt=DT, solver="daqp")

    return step


def placos(robot: jtik.Robot, path: Path) -> Step:
    """placo as its documentation has it; it has a solver of its own, eiquadprog."""
    wrapper, kinematics, tip, full, offset, first = _placo(robot, path)

    def step(q: Array, target: Array) -> Array:
        full[offset:] = q
        wrapper.state.q = full
        wrapper.update_kinematics()
        tip.T_world_frame = target
        return np.array(kinematics.solve(False)[first:])

    return step


def placo_alone(robot: jtik.Robot, path: Path, clock: Clock) -> Callable[[], float]:
    """placo's kinematics and solve, with configuration and target in place already: its counterpart of a fused step."""
    wrapper, kinematics, tip, full, offset, _ = _placo(robot, path)

    def place(q: Array, target: Array) -> None:
        full[offset:] = q
        wrapper.state.q = full
        tip.T_world_frame = target

    def call() -> None:
        wrapper.update_kinematics()
        kinematics.solve(False)

    return _alone(place, lambda: call, path, clock)


def _placo(robot: jtik.Robot, path: Path) -> tuple[Any, ...]:
    import placo

    with tempfile.NamedTemporaryFile("w", suffix=".urdf", delete=False) as file:
        file.write(urdf(robot))
    try:
        wrapper = placo.RobotWrapper(file.name, placo.Flags.ignore_collisions)
    finally:
        os.unlink(file.name)
    kinematics = placo.KinematicsSolver(wrapper)
    kinematics.mask_fbase(True)
    kinematics.dt = DT
    kinematics.enable_joint_limits(True)
    kinematics.enable_velocity_limits(True)
    tip = kinematics.add_frame_task(robot.tip, np.eye(4))
    tip.configure("tip", "soft", 1.0, 1.0)
    posture = kinematics.add_joints_task()
    posture.set_joints(dict(zip(robot.joint_names, path.home.tolist(), strict=True)))
    posture.configure("posture", "soft", POSTURE_COST**2)  # a weight where others have a cost
    offset = wrapper.get_joint_offset(robot.joint_names[0])
    first = wrapper.get_joint_v_offset(robot.joint_names[0])
    full = wrapper.neutral_state().q.copy()
    return wrapper, kinematics, tip, full, offset, first


PEERS: dict[str, Callable[[jtik.Robot, Path], Step]] = {
    "mink (DAQP)": minks,
    "pink (DAQP)": pinks,
    "placo (C++)": placos,
}


def along(step: Step, path: Path, clock: Clock) -> Callable[[], float]:
    """Time of one step [s], averaged over the path; once round it before, for what the others left in the caches."""
    pairs = list(zip(path.q, path.targets, strict=True))

    def batch() -> float:
        for q, target in pairs:
            step(q, target)
        begin = clock()
        for q, target in pairs:
            step(q, target)
        return (clock() - begin) / len(pairs)

    return batch


def bare(ik: jtik.InverseKinematics, path: Path, clock: Clock) -> Callable[[], float]:
    """The fused step alone: configuration, target and box are in its memory already."""
    ik.step(path.q[0], path.targets[0], dt=DT)
    runner, _ = ik._engine.runners.timed

    def place(q: Array, target: Array) -> None:
        ik.step(q, target, dt=DT)
        runner.start(q)

    return _alone(place, lambda: runner.calls[0], path, clock)


def _alone(
    place: Callable[[Array, Array], None], call: Callable[[], Callable[[], None]], path: Path, clock: Clock
) -> Callable[[], float]:
    """Time of a call [s], REPEATED times in a row at every fifth place."""
    pairs = list(zip(path.q, path.targets, strict=True))[::5]

    def batch() -> float:
        seconds = 0.0
        for q, target in pairs:
            place(q, target)
            again = call()
            begin = clock()
            for _ in range(REPEATED):
                again()
            seconds += clock() - begin
        return seconds / (REPEATED * len(pairs))

    return batch


def independent_pose(robot: jtik.Robot) -> Callable[[Array], Array]:
    """The tip's pose by MuJoCo, which reads the URDF by itself."""
    spec = mujoco.MjSpec.from_string(urdf(robot))
    spec.compiler.fusestatic = False
    model = spec.compile()
    data = mujoco.MjData(model)
    places = [model.joint(name).qposadr[0] for name in robot.joint_names]

    def pose(q: Array) -> Array:
        data.qpos[places] = q
        mujoco.mj_kinematics(model, data)
        tip = np.eye(4)
        tip[:3, 3], tip[:3, :3] = data.body(robot.tip).xpos, data.body(robot.tip).xmat.reshape(3, 3)
        return tip

    return pose


def judged(step: Step, robot: jtik.Robot, path: Path, pose: Callable[[Array], Array]) -> tuple[float, float, float]:
    """What a step leaves of the error, median; how far beyond a limit one ended, at worst [rad]; steps at a limit."""
    left, over = [], []
    for q, target in zip(path.q, path.targets, strict=True):
        dq = step(q, target)
        after = q + dq
        beyond = (after - robot.upper, robot.lower - after, abs(dq) - DT * robot.velocity_limit)
        over.append(float(np.max(beyond)))
        left.append(_error(pose(after), target) / _error(pose(q), target))
    return float(np.median(left)), max(*over, 0.0), float(np.mean(np.array(over) > -ACCURACY))


def _error(pose: Array, target: Array) -> float:
    """Distance [m] and angle [rad] as one number."""
    cosine = (np.trace(target[:3, :3].T @ pose[:3, :3]) - 1) / 2
    turn = np.linalg.norm(target[:3, :3] - pose[:3, :3]) / np.sqrt(2) if cosine > 0.99 else np.arccos(cosine)
    return float(np.hypot(np.linalg.norm(pose[:3, 3] - target[:3, 3]), turn))


def interleaved(timers: dict[str, Callable[[], float]], rounds: int) -> dict[str, Array]:
    """Times [us] of every round, by name; each round begins with another timer, the first two are thrown away."""
    times: dict[str, list[float]] = {name: [] for name in timers}
    names = list(timers)
    gc.disable()
    for k in range(rounds + 2):
        for name in names[k % len(names) :] + names[: k % len(names)]:
            times[name].append(1e6 * timers[name]())
        gc.collect()
    gc.enable()
    return {name: np.array(each[2:]) for name, each in times.items()}


def add_times(
    rows: dict[str, Any], timers: dict[str, Callable[[], float]], repeats: int, row: Callable[[str], Any]
) -> None:
    """Time everything in turns, into its row or a new one."""
    for name, times in interleaved(timers, repeats).items():
        p10, median, p90 = (float(x) for x in np.percentile(times, [10, 50, 90]))
        rows[name] = replace(rows.get(name) or row(name), median=median, p10=p10, p90=p90)


def write_json(rows: list[Any], arguments: argparse.Namespace) -> None:
    """Rows, options and machine, into the file asked for or, for '-', to standard output."""
    record = {
        "machine": f"{platform.machine()}, {platform.system()}",
        "python": platform.python_version(),
        "packages": package_versions(),
        "options": {name: value for name, value in vars(arguments).items() if name != "json"},
        "rows": [asdict(row) for row in rows],
    }
    text = json.dumps(record, indent=2)
    if arguments.json == "-":
        print(text)
    else:
        pathlib.Path(arguments.json).write_text(text, encoding="utf-8")


def main() -> None:
    """Build, judge, time, print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=60, help="rounds (default %(default)s)")
    parser.add_argument("--compiled", action="store_true", help="jtik's step as generated C")
    parser.add_argument("--path", choices=list(PATHS), default="tracked", help="where to step (default %(default)s)")
    parser.add_argument("--strategies", nargs="+", default=list(STRATEGIES))
    parser.add_argument("--cpu", action="store_true", help="processor time in place of time: for a busy machine")
    parser.add_argument("--json", metavar="FILE", help="also write the figures to FILE, '-' for standard output")
    arguments = parser.parse_args()
    if arguments.repeats < 1:
        parser.error("--repeats must be at least 1")

    clock = time.thread_time if arguments.cpu else time.perf_counter
    panda = jtik.Robot.builtin("panda")
    robot = jtik.Robot.from_urdf(urdf(panda), tip=panda.tip)
    path = PATHS[arguments.path](robot, panda.keyframes["home"])
    pose = independent_pose(robot)
    rows: dict[str, Row] = {}
    timers: dict[str, Callable[[], float]] = {}

    def add(name: str, step: Step) -> None:
        left, beyond, active = judged(step, robot, path, pose)
        rows[name] = Row(name, left=left, beyond=beyond, active=active)
        timers[name] = along(step, path, clock)

    for strategy in arguments.strategies:
        ik = solver(robot, path, strategy, compiled=arguments.compiled)
        add(f"jtik {strategy}, ik.step", stepping(ik))
        timers[f"jtik {strategy}, fused"] = bare(
            solver(robot, path, strategy, compiled=arguments.compiled), path, clock
        )
    for name, build in PEERS.items():
        try:
            add(name, build(robot, path))
            if build is placos:
                timers["placo (C++), alone"] = placo_alone(robot, path, clock)
        except ImportError as error:
            rows[name] = Row(name, missing=f"not installed: {error}")

    add_times(rows, timers, arguments.repeats, Row)
    show(list(rows.values()))
    if arguments.json:
        write_json(list(rows.values()), arguments)


def show(rows: list[Row]) -> None:
    """A table with ratios to mink and to placo alone."""
    by_name = {row.name: row.median for row in rows}
    mink, placo = by_name.get("mink (DAQP)", np.nan), by_name.get("placo (C++), alone", np.nan)
    width = max(len(row.name) for row in rows)
    print(f"{'':{width}}  median [us]    10 %    90 %  mink /  placo /  error left  beyond limits  at limits")
    for row in rows:
        if row.missing:
            print(f"{row.name:{width}}  {row.missing}")
            continue
        kept = (
            ""
            if np.isnan(row.left)
            else f"  {row.left:10.1e}  {row.beyond if row.beyond > ACCURACY else 0:13.1e}  {row.active:9.0%}"
        )
        print(
            f"{row.name:{width}}  {row.median:11.2f}  {row.p10:6.2f}  {row.p90:6.2f}"
            f"  {mink / row.median:6.1f}  {placo / row.median:7.2f}{kept}"
        )


def package_versions() -> dict[str, str]:
    """Of what the figures depend on."""
    found = {}
    for package in PACKAGES:
        try:
            found[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            found[package] = "missing"
    return found


if __name__ == "__main__":
    sys.exit(main())
