"""One differential step of a Panda: pose task, weighted or lower-priority posture, position and velocity limits, DAQP.

It compares strategies of jtik with mink, pink and placo, on one URDF, along one path of configurations and targets, in
one process and interleaved. MuJoCo checks every answer: the remaining error, and violations of limits.

    python benchmarks/qp_step.py [--compiled] [--path saturated] [--cold] [--strategies newton+qp weighted_qp]

The other libraries are installed by

    python -m pip install mink pin-pink "placo==0.10.2"

which installs Pinocchio 3.8. A library that is not installed has a row that says so.
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
    os.environ.setdefault(variable, "1")  # threads do not speed up matrices of seven rows, and slow mink down

import mujoco  # noqa: E402
import numpy as np  # noqa: E402

import jtik  # noqa: E402
from jtik_formulations import JointCentering, WeightedQP  # noqa: E402

Array = np.ndarray
DT = 0.02
"""Time of a step [s]."""
TARGETS = 50
"""Number of configurations on the path; the target of each is one step of the path ahead."""
REPEATED = 50
"""Consecutive calls in the time of a call alone."""
POSTURE_COST = 1e-2
"""Cost of the posture relative to 1 for the pose, if a library weighs the two."""
ACCURACY = 1e-6
"""Allowed violation of a limit at the end of a step [rad]."""
STRATEGIES = ("newton+qp", "hybrid+qp", "weighted_qp")
PACKAGES = ("numpy", "casadi", "daqp", "mink", "pin-pink", "pin", "placo", "mujoco")

Step = Callable[[Array, Array], Array]
"""(q, target (4, 4)) -> displacement (n,)."""

Clock = Callable[[], float]
"""() -> time [s]."""


@dataclass(frozen=True)
class Row:
    """Figures of one kind of step.

    Attributes:
        name: name of the row.
        median: median time [us].
        p10: tenth percentile of the time [us].
        p90: ninetieth percentile of the time [us].
        left: median share of the pose error that remains after a step.
        beyond: largest violation of a position or velocity limit [rad].
        active: share of steps with a joint at a limit.
        missing: why there are no figures.
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
    """Kinematics and limits as a URDF for all libraries; all masses are equal."""
    inertial = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    links = "".join(f'<link name="{frame}">{inertial}</link>' for frame in robot.frame_names)
    joints = "".join(_joint(joint) for joint in robot.joints)
    return f'<robot name="{robot.name}">{links}{joints}</robot>'


def _joint(joint: jtik.Joint) -> str:
    R, p = joint.origin[:3, :3], joint.origin[:3, 3]
    rpy = (np.arctan2(R[2, 1], R[2, 2]), np.arcsin(np.clip(-R[2, 0], -1, 1)), np.arctan2(R[1, 0], R[0, 0]))
    xyz, turn, axis = (" ".join(repr(float(x)) for x in values) for values in (p, rpy, joint.axis))
    # pink requires different names for frames and joints
    name = joint.name if joint.is_moving else f"{joint.name} mount"
    limit = ""
    if joint.is_moving:
        limit = (
            f'<limit lower="{joint.lower!r}" upper="{joint.upper!r}" velocity="{joint.velocity_limit!r}" effort="1"/>'
        )
    ends = f'<parent link="{joint.parent}"/><child link="{joint.child}"/>'
    return (
        f'<joint name="{name}" type="{joint.type.value}">{ends}<origin xyz="{xyz}" rpy="{turn}"/>'
        f'<axis xyz="{axis}"/>{limit}</joint>'
    )


@dataclass(frozen=True)
class Path:
    """Configurations and the targets of their steps.

    Attributes:
        home: preferred posture, (n,).
        q: configurations, (n,) each.
        targets: target of each configuration, (4, 4).
        rate: rate at which the posture is approached [1/s]; infinite as in the other libraries.
    """

    home: Array
    q: list[Array]
    targets: list[Array]
    rate: float = 5.0

    @classmethod
    def tracked(cls, robot: jtik.Robot, home: Array) -> Path:
        """Tracking as in a controller: the tip follows a closed curve, and the arm is close to its preferred posture.

        Few joints are at position or velocity limits. The path is tracked by `hybrid`, which is not among the rows.
        """
        ik = jtik.InverseKinematics(robot, jtik.FrameTask(robot.tip, kind="pose"), criteria=JointCentering())
        ik.parameters["joint_centering.preferred"] = home
        lap = [robot.pose(q) for q in _curve(robot, home, TARGETS)]
        q, recorded = home, []
        for target in 3 * lap:
            recorded.append(q)
            q = ik.track([target], q0=q, dt=DT, until="stationary", max_iterations=20).q[0]
        return cls(home, recorded[-TARGETS:], lap)

    @classmethod
    def saturated(cls, robot: jtik.Robot, home: Array) -> Path:
        """Configurations away from the preferred posture, to which a step goes at once: velocity limits are active."""
        q = _curve(robot, home, TARGETS)
        return cls(home, q, [robot.pose(ahead) for ahead in [*q[1:], q[0]]], np.inf)


def _curve(robot: jtik.Robot, home: Array, count: int) -> list[Array]:
    """A closed curve around ``home`` with at most half of the velocity limits."""
    generator = np.random.default_rng(0)
    phase, widest = generator.uniform(0, 2 * np.pi, robot.n), 0.5 * DT * robot.velocity_limit * count / (2 * np.pi)
    amplitude = np.minimum(generator.uniform(0.2, 0.5, robot.n), widest)
    angle = np.linspace(0, 2 * np.pi, count, endpoint=False)
    return [np.clip(home + amplitude * np.sin(a + phase), robot.lower + 0.05, robot.upper - 0.05) for a in angle]


PATHS: dict[str, Callable[[jtik.Robot, Array], Path]] = {"tracked": Path.tracked, "saturated": Path.saturated}


def solver(robot: jtik.Robot, path: Path, strategy: str, *, compiled: bool) -> jtik.InverseKinematics:
    """The problem for jtik."""
    chosen = WeightedQP(weight=POSTURE_COST**2) if strategy == "weighted_qp" else strategy
    ik = jtik.InverseKinematics(
        robot,
        jtik.FrameTask(robot.tip, kind="pose"),
        criteria=JointCentering(),
        strategy=chosen,
        compiled=compiled,
        null_space_rate=path.rate,
    )
    ik.parameters["joint_centering.preferred"] = path.home
    return ik


def stepping(ik: jtik.InverseKinematics) -> Step:
    """``ik.step`` as a controller calls it."""

    def step(q: Array, target: Array) -> Array:
        return ik.step(q, target, dt=DT).q - q

    return step


def minks(robot: jtik.Robot, path: Path) -> Step:
    """mink as in its examples, with limits and other options at their defaults."""
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
    """pink as in its examples, which include limits by default."""
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
    """placo as in its documentation, with its own solver eiquadprog."""
    wrapper, kinematics, tip, full, offset, first = _placo(robot, path)

    def step(q: Array, target: Array) -> Array:
        full[offset:] = q
        wrapper.state.q = full
        wrapper.update_kinematics()
        tip.T_world_frame = target
        return np.array(kinematics.solve(False)[first:])

    return step


def placo_alone(robot: jtik.Robot, path: Path, clock: Clock) -> Callable[[], float]:
    """Kinematics and solve of placo with configuration and target already set: the counterpart of a fused step."""
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
    posture.configure("posture", "soft", POSTURE_COST**2)  # placo has weights, the other libraries have costs
    offset = wrapper.get_joint_offset(robot.joint_names[0])
    first = wrapper.get_joint_v_offset(robot.joint_names[0])
    full = wrapper.neutral_state().q.copy()
    return wrapper, kinematics, tip, full, offset, first


PEERS: dict[str, Callable[[jtik.Robot, Path], Step]] = {
    "mink (DAQP)": minks,
    "pink (DAQP)": pinks,
    "placo (C++)": placos,
}


def path_time(step: Step, path: Path, clock: Clock, *, cold: bool = False) -> Callable[[], float]:
    """Mean time of a step over the path [s], after one lap to fill the caches, or each after `other_work`."""
    pairs = list(zip(path.q, path.targets, strict=True))

    def cold_batch() -> float:
        seconds = 0.0
        for q, target in pairs:
            other_work()
            begin = clock()
            step(q, target)
            seconds += clock() - begin
        return seconds / len(pairs)

    def batch() -> float:
        for q, target in pairs:
            step(q, target)
        begin = clock()
        for q, target in pairs:
            step(q, target)
        return (clock() - begin) / len(pairs)

    return cold_batch if cold else batch


_MEMORY = np.zeros(1 << 20)


def other_work() -> None:
    """What a controller does between two steps: other code, and 8 MB of memory."""
    _MEMORY[:] += 1.0
    json.loads(json.dumps({"names": PACKAGES, "values": np.linalg.solve(np.eye(20), _MEMORY[:20]).tolist()}))


def step_alone(ik: jtik.InverseKinematics, path: Path, clock: Clock) -> Callable[[], float]:
    """The fused step alone, with configuration, target and limits already set."""
    ik.step(path.q[0], path.targets[0], dt=DT)
    runner, _ = ik._engine.runners.timed_step

    def place(q: Array, target: Array) -> None:
        ik.step(q, target, dt=DT)
        runner.start(q)

    return _alone(place, lambda: runner.calls[0], path, clock)


def _alone(
    place: Callable[[Array, Array], None], call: Callable[[], Callable[[], None]], path: Path, clock: Clock
) -> Callable[[], float]:
    """Mean time of a call [s], repeated REPEATED times at every fifth configuration."""
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
    """Pose of the tip by MuJoCo, which reads the URDF itself."""
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


def checked(step: Step, robot: jtik.Robot, path: Path, pose: Callable[[Array], Array]) -> tuple[float, float, float]:
    """Median remaining share of the error, largest violation of a limit [rad], and share of steps at a limit."""
    left, over = [], []
    for q, target in zip(path.q, path.targets, strict=True):
        dq = step(q, target)
        after = q + dq
        beyond = (after - robot.upper, robot.lower - after, abs(dq) - DT * robot.velocity_limit)
        over.append(float(np.max(beyond)))
        left.append(_error(pose(after), target) / _error(pose(q), target))
    return float(np.median(left)), max(*over, 0.0), float(np.mean(np.array(over) > -ACCURACY))


def _error(pose: Array, target: Array) -> float:
    """Distance [m] and angle [rad] combined to one norm."""
    cosine = (np.trace(target[:3, :3].T @ pose[:3, :3]) - 1) / 2
    turn = np.linalg.norm(target[:3, :3] - pose[:3, :3]) / np.sqrt(2) if cosine > 0.99 else np.arccos(cosine)
    return float(np.hypot(np.linalg.norm(pose[:3, 3] - target[:3, 3]), turn))


def interleaved(timers: dict[str, Callable[[], float]], rounds: int) -> dict[str, Array]:
    """Times of every round by name [us]. Each round begins with another timer; the first two rounds are discarded."""
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
    """Run all timers interleaved and add their times to the rows."""
    for name, times in interleaved(timers, repeats).items():
        p10, median, p90 = (float(x) for x in np.percentile(times, [10, 50, 90]))
        rows[name] = replace(rows.get(name) or row(name), median=median, p10=p10, p90=p90)


def write_json(rows: list[Any], arguments: argparse.Namespace) -> None:
    """Write rows, options and machine to a file, or to standard output for '-'."""
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
    """Build, check, time and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=60, help="rounds (default %(default)s)")
    parser.add_argument("--compiled", action="store_true", help="jtik's step as generated C")
    parser.add_argument(
        "--path", choices=list(PATHS), default="tracked", help="path of configurations (default %(default)s)"
    )
    parser.add_argument("--strategies", nargs="+", default=list(STRATEGIES))
    parser.add_argument("--cold", action="store_true", help="other work between two steps; not for rows of calls alone")
    parser.add_argument("--cpu", action="store_true", help="processor time instead of wall time, for a busy machine")
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
        left, beyond, active = checked(step, robot, path, pose)
        rows[name] = Row(name, left=left, beyond=beyond, active=active)
        timers[name] = path_time(step, path, clock, cold=arguments.cold)

    for strategy in arguments.strategies:
        ik = solver(robot, path, strategy, compiled=arguments.compiled)
        add(f"jtik {strategy}, ik.step", stepping(ik))
        timers[f"jtik {strategy}, fused"] = step_alone(
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
    """Print a table with ratios to mink and to placo alone."""
    by_name = {row.name: row.median for row in rows}
    mink, placo = by_name.get("mink (DAQP)", np.nan), by_name.get("placo (C++), alone", np.nan)
    width = max(len(row.name) for row in rows)
    print(f"{'':{width}}  median [us]    10 %    90 %  mink /  placo /  error left  beyond limits  at limits")
    for row in rows:
        if row.missing:
            print(f"{row.name:{width}}  {row.missing}")
            continue
        extra = (
            ""
            if np.isnan(row.left)
            else f"  {row.left:10.1e}  {row.beyond if row.beyond > ACCURACY else 0:13.1e}  {row.active:9.0%}"
        )
        print(
            f"{row.name:{width}}  {row.median:11.2f}  {row.p10:6.2f}  {row.p90:6.2f}"
            f"  {mink / row.median:6.1f}  {placo / row.median:7.2f}{extra}"
        )


def package_versions() -> dict[str, str]:
    """Versions of the packages that the figures depend on."""
    found = {}
    for package in PACKAGES:
        try:
            found[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            found[package] = "missing"
    return found


if __name__ == "__main__":
    sys.exit(main())
