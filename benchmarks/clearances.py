"""One step of ten links among four circles, with clearance constraints for all 40 pairs of links and circles, DAQP.

It compares strategies of jtik with mink (collision limit) and placo (collision constraint), along one closed path of
the tip, in closed loop, in one process and interleaved. Clearances along each step and the distance of the tip from its
target are checked in closed form.

    python benchmarks/clearances.py [--strategies hybrid+qp weighted_qp] [--code C] [--cpu]

The other libraries are those of qp_step.py. A library that is not installed has a row that says so.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from qp_step import (  # sets the number of threads, so it is imported before NumPy
    DT,
    POSTURE_COST,
    REPEATED,
    STRATEGIES,
    Clock,
    add_times,
    other_work,
    write_json,
)

# isort: split
import numpy as np

import jtik
from jtik_formulations import JointCentering, ObstacleAvoidance, WeightedQP

Array = np.ndarray
LINKS, LENGTH, RADIUS = 10, 0.1, 0.01
"""Number, length [m] and radius [m] of the links, which are capsules."""
CIRCLES = (
    jtik.Circle((0.02, 0.25), 0.05),
    jtik.Circle((0.33, 0.11), 0.06),
    jtik.Circle((0.53, 0.35), 0.05),
    jtik.Circle((0.62, 0.12), 0.05),
)
SAFE = 0.01
"""Required clearance [m]."""
ALL_PAIRS = 10.0
"""Detection distance that includes all pairs [m]."""
CLOSE_PAIRS = 0.1
"""Detection distance that includes close pairs only [m]."""
HOME = np.array([1.3, -0.4, -0.4, -0.4, -0.4, 0.2, 0.4, 0.4, 0.4, 0.2])
"""Start of the path, and preferred posture [rad]."""
TARGETS = 100
"""Number of targets on the path."""
CHECKED_LAPS = 3
"""Number of laps of the path that are checked."""
SAMPLES = 25
"""Number of configurations along a step at which the clearance is measured."""
EVERY = 5
"""Every n-th target is used for the time of a call alone."""
CODES = ("C", "machine")

Step = Callable[[Array, Any], "Array | None"]
"""(q, target) -> q (n,) after the step; None if there is no answer."""


@dataclass(frozen=True)
class Row:
    """Figures of one kind of step.

    Attributes:
        name: name of the row.
        median: median time [us].
        p10: tenth percentile of the time [us].
        p90: ninetieth percentile of the time [us].
        clearance: smallest clearance along all steps [mm].
        missed: median distance of the tip from the target after a step [mm].
        worst: largest distance of the tip from the target after a step [mm].
        near: share of steps that end within 21 mm of a circle.
        unanswered: number of steps without an answer.
        missing: why there are no figures.
    """

    name: str
    median: float = math.nan
    p10: float = math.nan
    p90: float = math.nan
    clearance: float = math.nan
    missed: float = math.nan
    worst: float = math.nan
    near: float = math.nan
    unanswered: int = 0
    missing: str = ""


def arm() -> jtik.Robot:
    """Planar arm of capsules with position and velocity limits."""
    plain = jtik.Robot.planar([LENGTH] * LINKS, lower=-2.0, upper=2.0, velocity_limit=2.0)
    capsule = jtik.Capsule((0.0, 0.0, 0.0), (LENGTH, 0.0, 0.0), RADIUS)
    shapes = {f"link{i}": (capsule,) for i in range(1, LINKS + 1)}
    return jtik.Robot(plain.joints, name="ten", planar=True, tip=plain.tip, shapes=shapes)


def points(q: Array) -> Array:
    """The ends of all links, (..., n + 1, 2), in closed form."""
    angle = np.cumsum(q, axis=-1)
    ends = np.cumsum(LENGTH * np.stack([np.cos(angle), np.sin(angle)], axis=-1), axis=-2)
    return np.concatenate([np.zeros((*q.shape[:-1], 1, 2)), ends], axis=-2)


def clearances(q: Array) -> Array:
    """Distances of all links' surfaces to all circles [m], (..., n, 4)."""
    ends = points(q)
    start, along = ends[..., :-1, None, :], np.diff(ends, axis=-2)[..., None, :]
    centers = np.array([circle.center for circle in CIRCLES])
    share = np.clip(((centers - start) * along).sum(-1) / LENGTH**2, 0, 1)
    gap = np.linalg.norm(start + share[..., None] * along - centers, axis=-1)
    return gap - np.array([circle.radius for circle in CIRCLES]) - RADIUS


def targets() -> list[Array]:
    """One lap from the tip position at home, between the circles, half a centimetre for each step."""
    tip, angle = points(HOME)[-1], np.linspace(0, 2 * np.pi, TARGETS, endpoint=False)
    return list(tip + np.stack([0.06 * (np.cos(angle) - 1), 0.10 * np.sin(angle)], axis=-1))


def solver(robot: jtik.Robot, strategy: str, *, code: str, restore: bool = True) -> jtik.InverseKinematics:
    """The problem for jtik, with a constraint row for every pair at any distance."""
    measure = ObstacleAvoidance(CIRCLES, bodies="shapes")
    ik = jtik.InverseKinematics(
        robot,
        jtik.FrameTask(),
        criteria=JointCentering(),
        strategy=WeightedQP(weight=POSTURE_COST**2) if strategy == "weighted_qp" else strategy,
        clearances=jtik.Clearance(measure, safe=SAFE, influence=math.inf, restore=restore),
        compiled=code == "C",
    )
    ik.parameters["joint_centering.preferred"] = HOME
    return ik


def stepping(ik: jtik.InverseKinematics) -> Step:
    """``ik.step`` as a controller calls it."""

    def step(q: Array, target: Array) -> Array:
        return ik.step(q, target, dt=DT).q

    return step


def minks(robot: jtik.Robot, *, gain: float = 0.85, within: float = ALL_PAIRS) -> Step:
    """mink as in its examples. Its collision limit bounds displacements by gain (d - safe) / dt."""
    import mink

    from jtik.interop.mink import to_mujoco, velocity_limit

    model = to_mujoco(robot, obstacles=CIRCLES)
    configuration = mink.Configuration(model)
    tip = mink.FrameTask(robot.tip, "body", position_cost=[1.0, 1.0, 0.0], orientation_cost=0.0)
    posture = mink.PostureTask(model, cost=POSTURE_COST)
    posture.set_target(HOME)
    links, circles = [f"link{i} solid0" for i in range(1, LINKS + 1)], [f"obstacle{i}" for i in range(len(CIRCLES))]
    clear = mink.CollisionAvoidanceLimit(
        model,
        [(links, circles)],
        gain=gain,
        minimum_distance_from_collisions=SAFE,
        collision_detection_distance=within,
    )
    assert clear.max_num_contacts == LINKS * len(CIRCLES)
    tasks, limits = [tip, posture], [mink.ConfigurationLimit(model), velocity_limit(robot, model), clear]

    def step(q: Array, target: Array) -> Array | None:
        configuration.update(q)
        tip.set_target(mink.SE3.from_translation(np.append(target, 0.0)))
        try:
            v = mink.solve_ik(configuration=configuration, tasks=tasks, dt=DT, solver="daqp", limits=limits)
        except mink.NoSolutionFound:
            return None
        return q + DT * v

    return step


def minks_scaled(robot: jtik.Robot) -> Step:
    """mink with a gain that compensates the division by dt, as its documentation describes."""
    return minks(robot, gain=0.85 * DT)


def minks_close(robot: jtik.Robot) -> Step:
    """mink with its broad phase: distant pairs have no distance and an empty row."""
    return minks(robot, gain=0.85 * DT, within=CLOSE_PAIRS)


@dataclass(frozen=True)
class PlacoStep:
    """A step of placo, with its collision constraint on the pairs of links and circles, which are fixed to the base.

    Attributes:
        wrapper: the robot.
        kinematics: the solver.
        tip: the task of the tip.
        full: q of the floating-base robot.
        offset: index of the first joint in q.
        first: index of the first joint in the velocity.
    """

    wrapper: Any
    kinematics: Any
    tip: Any
    full: Array
    offset: int
    first: int

    @classmethod
    def of(cls, robot: jtik.Robot, within: float) -> PlacoStep:
        """Build it from a URDF of the arm and the circles."""
        import placo

        with tempfile.TemporaryDirectory() as folder:
            description, pairs = os.path.join(folder, "robot.urdf"), os.path.join(folder, "collisions.json")
            with open(description, "w", encoding="utf-8") as file:
                file.write(urdf(robot))
            with open(pairs, "w", encoding="utf-8") as file:
                circles = [f"circle{i}" for i in range(len(CIRCLES))]
                json.dump([[f"link{i}", circle] for i in range(1, LINKS + 1) for circle in circles], file)
            wrapper = placo.RobotWrapper(description)
            wrapper.load_collision_pairs(pairs)
        kinematics = placo.KinematicsSolver(wrapper)
        kinematics.mask_fbase(True)
        kinematics.dt = DT
        kinematics.enable_joint_limits(True)
        kinematics.enable_velocity_limits(True)
        tip = kinematics.add_position_task(robot.tip, np.zeros(3))
        tip.mask.set_axises("xy")
        tip.configure("tip", "soft", 1.0)
        posture = kinematics.add_joints_task()
        posture.set_joints(dict(zip(robot.joint_names, HOME.tolist(), strict=True)))
        posture.configure("posture", "soft", POSTURE_COST**2)  # placo has weights, the other libraries have costs
        clear = kinematics.add_avoid_self_collisions_constraint()
        clear.self_collisions_margin, clear.self_collisions_trigger = SAFE, within
        clear.configure("clear", "hard")
        wrapper.update_kinematics()
        assert len(wrapper.distances()) == LINKS * len(CIRCLES)
        offset = wrapper.get_joint_offset(robot.joint_names[0])
        first = wrapper.get_joint_v_offset(robot.joint_names[0])
        return cls(wrapper, kinematics, tip, wrapper.neutral_state().q.copy(), offset, first)

    def place(self, q: Array, target: Array) -> None:
        """Set configuration and target."""
        self.full[self.offset :] = q
        self.wrapper.state.q = self.full
        self.tip.target_world = np.append(target, 0.0)

    def __call__(self, q: Array, target: Array) -> Array | None:
        """One step."""
        self.place(q, target)
        self.wrapper.update_kinematics()
        try:
            return q + np.array(self.kinematics.solve(False)[self.first :])
        except RuntimeError:  # raised if the quadratic program has no solution
            return None

    def alone(self) -> None:
        """Kinematics and solve with configuration and target already set: the counterpart of a fused step."""
        self.wrapper.update_kinematics()
        self.kinematics.solve(False)


def placos(robot: jtik.Robot) -> Step:
    """placo with a constraint row for every pair."""
    return PlacoStep.of(robot, ALL_PAIRS)


def placos_close(robot: jtik.Robot) -> Step:
    """placo with constraint rows for close pairs only."""
    return PlacoStep.of(robot, CLOSE_PAIRS)


def urdf(robot: jtik.Robot) -> str:
    """URDF of the arm with capsules, which Pinocchio makes from marked cylinders, and of the circles as spheres."""
    inertial = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    parts = [f'<link name="{robot.base}">{inertial}</link>']
    for i, circle in enumerate(CIRCLES):
        x, y = circle.center
        parts.append(
            f'<link name="circle{i}">{inertial}<collision><geometry><sphere radius="{circle.radius}"/></geometry>'
            f'</collision></link><joint name="mount{i}" type="fixed"><parent link="{robot.base}"/>'
            f'<child link="circle{i}"/><origin xyz="{x} {y} 0"/></joint>'
        )
    for joint in robot.joints:
        shape = limit = ""
        if joint.is_moving:
            limit = (
                f'<axis xyz="0 0 1"/><limit lower="{joint.lower}" upper="{joint.upper}" '
                f'velocity="{joint.velocity_limit}" effort="1"/>'
            )
            shape = (
                f'<collision_checking><capsule name="{joint.child}_body"/></collision_checking>'
                f'<collision name="{joint.child}_body"><origin xyz="{LENGTH / 2} 0 0" rpy="0 {math.pi / 2} 0"/>'
                f'<geometry><cylinder radius="{RADIUS}" length="{LENGTH}"/></geometry></collision>'
            )
        kind, name = ("revolute", joint.name) if joint.is_moving else ("fixed", f"{joint.name} mount")
        x, y, z = joint.origin[:3, 3]
        parts.append(
            f'<link name="{joint.child}">{inertial}{shape}</link><joint name="{name}" type="{kind}">'
            f'<parent link="{joint.parent}"/><child link="{joint.child}"/><origin xyz="{x} {y} {z}"/>{limit}</joint>'
        )
    return f'<robot name="{robot.name}">{"".join(parts)}</robot>'


PEERS: dict[str, Callable[[jtik.Robot], Step]] = {
    "mink (DAQP)": minks,
    "mink (DAQP), gain times dt": minks_scaled,
    "mink (DAQP), gain times dt, near pairs": minks_close,
    "placo (C++)": placos,
    "placo (C++), near pairs": placos_close,
}
"""Builders of the steps. Ratios refer to the first row of each library. All require the same clearance."""


def checked(name: str, step: Step) -> Row:
    """Run CHECKED_LAPS laps and check clearances and distances."""
    q, smallest, missed, near, unanswered = HOME, math.inf, [], [], 0
    share = np.linspace(0, 1, SAMPLES)[:, None]
    for target in CHECKED_LAPS * targets():
        after = step(q, target)
        if after is None:
            unanswered, after = unanswered + 1, q
        along_step = clearances(q + share * (after - q)).min(axis=(-1, -2))
        smallest = min(smallest, float(along_step.min()))
        near.append(along_step[-1] < 0.02 + 1e-3)
        missed.append(1e3 * float(np.linalg.norm(points(after)[-1] - target)))
        q = after
    return Row(
        name,
        clearance=1e3 * smallest,
        missed=float(np.median(missed)),
        worst=float(np.max(missed)),
        near=float(np.mean(near)),
        unanswered=unanswered,
    )


def lap_time(step: Step, home: Array, path: Sequence[Any], clock: Clock, *, cold: bool = False) -> Callable[[], float]:
    """Mean time of a step over one lap in closed loop [s], after a lap to fill the caches, or each after other work."""
    q = home

    def run_lap() -> None:
        nonlocal q
        for target in path:
            after = step(q, target)
            if after is not None:
                q = after

    def cold_batch() -> float:
        nonlocal q
        seconds = 0.0
        for target in path:
            other_work()
            begin = clock()
            after = step(q, target)
            seconds += clock() - begin
            if after is not None:
                q = after
        return seconds / len(path)

    def batch() -> float:
        run_lap()
        begin = clock()
        run_lap()
        return (clock() - begin) / len(path)

    return cold_batch if cold else batch


def step_alone(ik: jtik.InverseKinematics, home: Array, path: Sequence[Any], clock: Clock) -> Callable[[], float]:
    """The fused step alone, at configurations of its own closed loop and with the state that it had there."""
    q, recorded = home, []
    for i, target in enumerate([*path, *path]):
        if i >= len(path) and i % EVERY == 0:
            recorded.append((q, target, runner_of(ik).state[runner_of(ik).at].copy()))
        q = ik.step(q, target, dt=DT).q
    runner = runner_of(ik)

    def place(q: Array, target: Any, state: Array) -> None:
        ik.step(q, target, dt=DT)  # writes target and limits to the inputs of the step
        runner.start(q)
        runner.state[0][:] = state

    again = runner.calls[0]
    return repeated([lambda each=each: place(*each) for each in recorded], again, clock)


def runner_of(ik: jtik.InverseKinematics) -> Any:
    """The runner that ``ik.step`` with dt uses."""
    return ik._engine.runners.timed_step[0]


def placo_alone(robot: jtik.Robot, within: float, clock: Clock) -> Callable[[], float]:
    """Kinematics and solve of placo, at configurations of its own closed loop."""
    placo, q, recorded = PlacoStep.of(robot, within), HOME, []
    for i, target in enumerate(2 * targets()):
        if i >= TARGETS and i % EVERY == 0:
            recorded.append((q, target))
        after = placo(q, target)
        q = q if after is None else after
    return repeated([lambda each=each: placo.place(*each) for each in recorded], placo.alone, clock)


def repeated(setups: list[Callable[[], None]], call: Callable[[], None], clock: Clock) -> Callable[[], float]:
    """Mean time of a call [s], repeated REPEATED times at every configuration."""

    def batch() -> float:
        seconds = 0.0
        for set_up in setups:
            set_up()
            call()
            begin = clock()
            for _ in range(REPEATED):
                call()
            seconds += clock() - begin
        return seconds / (REPEATED * len(setups))

    return batch


def main() -> None:
    """Build, check, time and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=40, help="rounds (default %(default)s)")
    parser.add_argument("--strategies", nargs="+", default=list(STRATEGIES))
    parser.add_argument(
        "--code",
        nargs="+",
        choices=CODES,
        default=list(CODES),
        help="evaluation of jtik's step: generated C or virtual machine",
    )
    parser.add_argument("--hold", action="store_true", help="jtik keeps violated clearances instead of restoring them")
    parser.add_argument("--cpu", action="store_true", help="processor time instead of wall time, for a busy machine")
    parser.add_argument("--json", metavar="FILE", help="also write the figures to FILE")
    arguments = parser.parse_args()
    if arguments.repeats < 1:
        parser.error("--repeats must be at least 1")

    clock = time.thread_time if arguments.cpu else time.perf_counter
    robot = arm()
    rows: dict[str, Row] = {}
    timers: dict[str, Callable[[], float]] = {}
    for strategy in arguments.strategies:
        for code in arguments.code:
            name, options = f"jtik {strategy}, {code}", {"code": code, "restore": not arguments.hold}
            rows[f"{name}, ik.step"] = checked(f"{name}, ik.step", stepping(solver(robot, strategy, **options)))
            timers[f"{name}, ik.step"] = lap_time(stepping(solver(robot, strategy, **options)), HOME, targets(), clock)
            timers[f"{name}, fused"] = step_alone(solver(robot, strategy, **options), HOME, targets(), clock)
    for name, build in PEERS.items():
        try:
            rows[name] = checked(name, build(robot))
        except ImportError as error:
            rows[name] = Row(name, missing=f"not installed: {error}")
            continue
        timers[name] = lap_time(build(robot), HOME, targets(), clock)
    for name, within in (("placo (C++)", ALL_PAIRS), ("placo (C++), near pairs", CLOSE_PAIRS)):
        if name in timers:
            timers[f"{name}, alone"] = placo_alone(robot, within, clock)

    add_times(rows, timers, arguments.repeats, Row)
    show(list(rows.values()))
    if arguments.json:
        write_json(list(rows.values()), arguments)


def show(rows: list[Row]) -> None:
    """Print a table with ratios to mink and to placo."""
    times = {row.name: row.median for row in rows}
    mink, placo = times.get("mink (DAQP)", math.nan), times.get("placo (C++)", math.nan)
    width = max(len(row.name) for row in rows)
    print(
        f"{'':{width}}  median [us]    10 %    90 %  mink /  placo /  "
        "clearance [mm]  tip error [mm]   worst  near  no answer"
    )
    for row in rows:
        if row.missing:
            print(f"{row.name:{width}}  {row.missing}")
            continue
        extra = ""
        if not math.isnan(row.clearance):
            extra = (
                f"  {row.clearance:14.3f}  {row.missed:14.3f}  {row.worst:6.2f}  {row.near:4.0%}  {row.unanswered:9d}"
            )
        print(
            f"{row.name:{width}}  {row.median:11.2f}  {row.p10:6.2f}  {row.p90:6.2f}"
            f"  {mink / row.median:6.1f}  {placo / row.median:7.2f}{extra}"
        )


if __name__ == "__main__":
    sys.exit(main())
