"""Two thousand random problems over every registered strategy and every back end, a third of them difficult.

A quick run has those of one case of every strategy and of every back end.

Difficult problems are unreachable, start outside the limits or at a singular posture, have their target beyond the
limits, or have obstacles whose clearances contradict each other.

Nothing raises, nothing is NaN, and limits and clearances hold at every configuration. Every status is checked with
independent kinematics: planar chains in closed form, Denavit-Hartenberg tables of the manufacturers in space, NumPy's
SVD, and SciPy's bounded least squares.

Its tests are thinned: ``--full`` runs all of them.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, replace

import numpy as np
import pytest
import qpsolvers
from scipy.optimize import least_squares, lsq_linear
from scipy.spatial.transform import Rotation as Rotation

import jtik
from jtik import Status
from jtik.qp import PersistentOSQP, QPSolversBackend, available
from jtik.registry import strategy_of
from jtik_formulations import JointCentering, ObstacleAvoidance

from ..conftest import planar, planar_jacobian, planar_points
from .test_gallery_tables import AHEAD, BACKWARDS, NONE, PANDA, UR5E, multiplied

pytestmark = pytest.mark.thinned("strategy", "backend")
"""Each strategy with one back end, in turn: ``--full`` runs all pairs."""

PROBLEMS = 2000
MAX_ITERATIONS = 60
"""Maximum iterations of a solve."""

TOLERANCE = 1e-6
"""Default tolerance of a solve: position [m], orientation [rad], and projected gradient."""

ROUNDING = 1e-9
"""Rounding difference of a pose [m], [rad] or a distance [m] between two implementations."""

AT_LIMIT = 1e-9
"""Distance within which a joint counts as at its limit [rad], [m]."""

FLAT = 1e-5
"""|J' e| / (|J| |e|) below which the error cannot decrease to first order."""

NEARLY_FLAT = 1e-3
"""The same below which a decrease may be too small to count."""

SAFE, MARGIN = 0.05, 0.01
"""Options of the clearances [m]."""


# --- arms, and independent kinematics


@dataclass(frozen=True)
class Arm:
    """A robot, the kind of its task, and independent kinematics.

    Attributes:
        robot: the robot.
        kind: kind of the frame task.
        straight: a singular posture.
        pose: q -> position or pose of the tip.
        jacobian: q -> Jacobian of the task.
        reach: largest distance of the tip from the base [m].
        too_near: smallest distance of the tip from the base within the limits [m].
    """

    robot: jtik.Robot
    kind: str
    straight: np.ndarray
    pose: object
    jacobian: object
    reach: float
    too_near: float = 0.0


def planar_arm(n, limit):
    """An arm with limits so narrow that the tip is closest to the base with all joints at one limit."""
    robot = planar(n, lower=-limit, upper=limit)
    nearest = math.sin(n * limit / 2) / math.sin(limit / 2)
    return Arm(robot, "position", np.zeros(n), lambda q: planar_points(q)[-1], planar_jacobian, n, nearest)


def vehicle():
    robot = jtik.Robot.vehicle(3, heading=True, lower=-1.5, upper=1.5, vehicle_lower=-1.0, vehicle_upper=1.0)

    def turned(q):
        return np.concatenate([[q[2] + q[3]], q[4:]])

    def jacobian(q):
        arm = planar_jacobian(turned(q))
        return np.column_stack([np.eye(2), arm[:, 0], arm])

    reach = 3 + math.sqrt(2)
    return Arm(robot, "position", np.zeros(6), lambda q: q[:2] + planar_points(turned(q))[-1], jacobian, reach)


def table_arm(name, kind, rows, before, after, convention, straight):
    """An arm from a Denavit-Hartenberg table, differentiated by complex steps."""
    robot = jtik.Robot.builtin(name)

    def pose_of(q):
        return before @ multiplied(rows, q, convention) @ after

    def pose(q):
        return pose_of(q)[:3, 3] if kind == "position" else pose_of(q)

    def jacobian(q):
        columns = []
        for unit in np.eye(len(q)):
            derivative = pose_of(q + 1e-30j * unit).imag / 1e-30
            skew = derivative[:3, :3] @ pose_of(q)[:3, :3].T
            rotation = [skew[2, 1], skew[0, 2], skew[1, 0]]
            columns.append([*derivative[:3, 3], *(rotation if kind == "pose" else [])])
        return np.array(columns).T

    reach = sum(abs(a) + abs(d) for _, a, d, _ in rows) + np.linalg.norm(after[:3, 3])
    return Arm(robot, kind, np.array(straight), pose, jacobian, float(reach))


HAND = AHEAD @ np.block(
    [[Rotation.from_euler("z", -45, degrees=True).as_matrix(), np.array([[0], [0], [0.1034]])], [np.zeros((1, 3)), 1]]
)

BUILD = {
    "planar3": lambda: planar_arm(3, 1.0),
    "planar5": lambda: planar_arm(5, 0.9),
    "planar10": lambda: planar_arm(10, 0.3),
    "vehicle": vehicle,
    "panda": lambda: table_arm(
        "panda", "pose", PANDA, NONE, HAND, "craig", [0.3, 0.0, math.pi / 2, -1.5, 0.0, 0.7, 0.2]
    ),
    "ur5e": lambda: table_arm("ur5e", "position", UR5E, BACKWARDS, NONE, "standard", [0.4, -0.8, 0.0, 0.5, 1.0, 0.2]),
}


@functools.cache
def arm_of(name):
    return BUILD[name]()


def error_of(arm, q, target):
    """The rows of the error, with rotations as rotation vectors in world axes."""
    pose = arm.pose(q)
    if arm.kind == "position":
        return pose - target
    turned = Rotation.from_matrix(pose[:3, :3] @ target[:3, :3].T).as_rotvec()
    return np.concatenate([pose[:3, 3] - target[:3, 3], turned])


# --- criteria, with their gradients


@jtik.criterion
def waves(q, robot):
    """A criterion that is both concave and convex in different regions."""
    import casadi

    return sum(casadi.cos(2 * q[i] + 0.3 * i) for i in range(robot.nq))


CRITERIA = {
    "none": (lambda: None, None),
    "centring": (JointCentering, lambda arm, q: q - arm.robot.neutral),
    "waves": (lambda: waves, lambda arm, q: -2 * np.sin(2 * q + 0.3 * np.arange(len(q)))),
}


# --- strategies, back ends, and their combinations


def _pairs(with_qp):
    """The registered strategies and compositions that use a QP solver, or those that do not."""
    names = list(jtik.strategies)
    for name in jtik.strategies:
        try:
            strategy_of(f"{name}+qp")
        except jtik.ArgumentError:
            continue
        names.append(f"{name}+qp")
    names.append("hybrid+second_order")
    return [name for name in names if strategy_of(name).uses_qp(True) == with_qp]


SLOW = ("clarabel", "quadprog", "qpsolvers:daqp", "qpsolvers:osqp", "persistent osqp")

BACKENDS = {
    **{name: lambda name=name: name for name in available()},
    **{f"qpsolvers:{name}": lambda name=name: QPSolversBackend(name) for name in ("daqp", "osqp")},
    "persistent osqp": PersistentOSQP,
}


@dataclass(frozen=True)
class Case:
    """Options of one InverseKinematics, and its number of problems.

    Attributes:
        strategy: name of the strategy.
        backend: name of the QP back end, or None.
        arm: name of the arm.
        criterion: name of the criterion.
        clear: whether it has clearances.
        count: number of problems.
        seed: seed of the problems.
    """

    strategy: str
    backend: str | None
    arm: str
    criterion: str
    clear: bool
    count: int = 0
    seed: int = 0


def _cases():
    found, arms, criteria = [], list(BUILD), list(CRITERIA)
    for i, strategy in enumerate(_pairs(False)):
        for j in range(3):
            found.append(Case(strategy, None, arms[(i + 2 * j) % 6], criteria[(i // 2 + j) % 3], False))
    for i, strategy in enumerate(_pairs(True)):
        backends = [name for name in BACKENDS if strategy != "mink" or name in qpsolvers.available_solvers]
        for j, backend in enumerate(backends):
            if backend != "daqp" and (i + j) % 2:
                continue
            for k in range(3 if backend == "daqp" else 1):
                arm = arms[(i + j // 2 + 2 * k) % 6]
                clear = arm == "planar5" and strategy_of(strategy).supports_clearances()
                number = i // 2 + j // 2 + k
                always = clear or strategy_of(strategy).uses_qp(False)
                criterion = criteria[number % 3 if always else 1 + number % 2]
                found.append(Case(strategy, backend, arm, criterion, clear))
    # slow back ends, which are called from Python, get a third of the problems
    share = np.array([1 if case.backend in SLOW else 3 for case in found])
    ends = (PROBLEMS * np.cumsum(share) / share.sum()).round().astype(int)
    counts = np.diff(ends, prepend=0).tolist()
    return [replace(case, count=count, seed=k) for k, (case, count) in enumerate(zip(found, counts, strict=True))]


CASES = _cases()


# --- problems

DIFFICULT = ("unreachable", "start outside", "singular", "target beyond limits", "contradictory clearances")


@dataclass(frozen=True)
class Problem:
    """One problem.

    Attributes:
        kind: "generic", or an entry of DIFFICULT.
        q0: start.
        target: target.
        centers: centres of the obstacles, (2, 2) [m].
        until: "reached" or "stationary".
        most: maximum iterations.
    """

    kind: str
    q0: np.ndarray
    target: np.ndarray
    centers: np.ndarray
    until: str
    most: int = MAX_ITERATIONS


FAR = np.array([[50.0, 0.0], [50.0, 5.0]])
RADIUS = 0.3


def problems_of(case):
    """The problems of a case; every third is difficult, and the kinds alternate."""
    rng = np.random.default_rng(case.seed)
    arm = arm_of(case.arm)
    for k in range(case.count):
        number = case.seed + k
        kind = DIFFICULT[number // 3 % len(DIFFICULT)] if number % 3 == 0 else "generic"
        until = ("stationary", "reached")[number // 2 % 2]
        slow = kind == "unreachable" and case.backend is None  # convergence to the last digits is slow there
        most = 6 * MAX_ITERATIONS if slow else MAX_ITERATIONS
        yield Problem(kind, *_drawn(arm, kind, case.clear, rng), until, most)


def _drawn(arm, kind, clear, rng):
    robot = arm.robot
    q0 = robot.random_configuration(rng)
    if kind == "contradictory clearances" and not clear:
        kind = "singular"
    if kind == "singular":
        q0 = arm.straight.copy()
    if kind == "start outside":
        q0 = q0 + rng.choice([-1, 1], robot.n) * rng.uniform(0.0, 4.0, robot.n)
    goal = robot.random_configuration(rng)
    if kind == "target beyond limits":
        goal = np.where(rng.random(robot.n) < 0.4, robot.upper + rng.uniform(0.1, 1.0, robot.n), goal)
    target = np.array(arm.pose(goal))
    if kind == "unreachable":
        place = target if target.ndim == 1 else target[:3, 3]
        target = _scaled(target, rng.uniform(1.2, 2.0) * arm.reach / np.linalg.norm(place))
    if kind == "singular":
        target = _scaled(np.array(arm.pose(q0)), rng.uniform(0.5, 0.95))
    if kind == "target beyond limits" and arm.too_near:
        heading = rng.uniform(-math.pi, math.pi)
        target = 0.5 * arm.too_near * np.array([math.cos(heading), math.sin(heading)])
    centers = FAR
    if clear:
        for _ in range(100):
            centers = rng.uniform(-3, 5, (2, 2))
            if min(gaps(q0, centers).min(), gaps(goal, centers).min()) > SAFE:
                break
        if kind == "contradictory clearances":
            points = np.vstack([[0.0, 0.0], planar_points(q0)])
            link = rng.integers(1, 5)
            along = points[link + 1] - points[link]
            across = np.array([-along[1], along[0]])
            off = (RADIUS + rng.uniform(0.2, 0.9) * SAFE) * across
            middle = points[link] + 0.5 * along
            centers = np.array([middle + off, middle - off])
    return q0, target, centers


def _scaled(target, by):
    """The target with its position multiplied by ``by``."""
    target = target.copy()
    if target.ndim == 1:
        return by * target
    target[:3, 3] *= by
    return target


def gaps(q, centers):
    """Distance of each link of a planar arm to each circle, from the closest point of its segment [m]."""
    points = np.vstack([[0.0, 0.0], planar_points(q)])
    a, along = points[:-1, None], np.diff(points, axis=0)[:, None]
    share = np.clip(((centers - a) * along).sum(-1) / (along**2).sum(-1), 0, 1)
    return np.linalg.norm(a + share[..., None] * along - centers, axis=-1) - RADIUS


# --- checks


def outside(robot, q):
    return np.maximum(np.maximum(robot.lower - q, q - robot.upper), 0.0)


def limits_at(robot, q):
    """+1, -1 or 0 for each joint: at its upper limit, at its lower limit, or at none."""
    return (q >= robot.upper - AT_LIMIT).astype(int) - (q <= robot.lower + AT_LIMIT).astype(int)


def projected(J, gradient, at):
    """Norm of the gradient of the Lagrangian, with the best multipliers of the task and of the active limits."""
    active = np.diag(at.astype(float))[:, at != 0]
    A = np.hstack([J.T, active])
    lowest = np.concatenate([np.full(len(J), -np.inf), np.zeros(active.shape[1])])
    found = lsq_linear(A, -gradient, bounds=(lowest, np.inf), method="bvls", tol=1e-14)
    return float(np.linalg.norm(A @ found.x + gradient))


def flatness(J, e, at):
    """|J' e| / (|J| |e|) over all joints, and over those that can move along -J' e."""
    gradient = J.T @ e
    free = at * gradient >= 0
    size = np.linalg.norm(J) * np.linalg.norm(e)
    return np.linalg.norm(gradient) / size, np.linalg.norm(gradient[free]) / size


def is_flat(relative_gradient, arm, q, target):
    """Whether the error cannot decrease: to first order; or by 0.2 % within 1 rad, where the gradient nearly vanishes.

    Joints at a limit that the error pushes outward stay where they are, as to first order.
    """
    if relative_gradient <= FLAT:
        return True
    if relative_gradient > NEARLY_FLAT:
        return False
    e = error_of(arm, q, target)
    reach = np.where(limits_at(arm.robot, q) * (arm.jacobian(q).T @ e) < 0, 0.0, 1.0)
    box = np.maximum(arm.robot.lower, q - reach) - 1e-12, np.minimum(arm.robot.upper, q + reach) + 1e-12
    options = {"bounds": box, "xtol": 1e-12, "ftol": 1e-12, "max_nfev": 50}
    best = least_squares(lambda at: error_of(arm, at, target), np.clip(q, *box), **options)
    return best.cost >= (1 - 2e-3) * 0.5 * np.sum(e**2)


def violations(case, arm, problem, solution, gradient_of):
    """Properties that a solution violates, one sentence each."""
    robot, q, status = arm.robot, solution.q, solution.status
    if not np.isfinite(q).all():
        return ["q is not finite"]
    found = []

    def require(good, sentence):
        if not good:
            found.append(sentence)

    require(not outside(robot, q).any(), f"outside its limits by {outside(robot, q).max():.3g}")
    require(solution.iterations <= problem.most, f"{solution.iterations} iterations")
    e, J, at = error_of(arm, q, problem.target), arm.jacobian(q), limits_at(robot, q)
    position, orientation = np.linalg.norm(e[:3]), np.linalg.norm(e[3:])
    scale = max(1.0, position)
    require(
        abs(solution.position_error - position) <= ROUNDING * scale, f"error {solution.position_error} is {position}"
    )
    require(
        abs(solution.orientation_error - orientation) <= 1e-7, f"angle {solution.orientation_error} is {orientation}"
    )
    require(status is not Status.NOT_FINITE, "NOT_FINITE")
    on_target = status in (Status.CONVERGED, Status.REACHED)
    if min(abs(position - TOLERANCE), abs(orientation - TOLERANCE)) > ROUNDING:
        reached = position <= TOLERANCE and orientation <= TOLERANCE
        require(on_target == reached, f"{status.name} at an error of {position:.3g} m, {orientation:.3g} rad")
    success = status is Status.CONVERGED or (status is Status.REACHED and problem.until == "reached")
    require(solution.converged == success, f"converged is {solution.converged} with {status.name}")
    if on_target and gradient_of is not None:
        gradient = gradient_of(arm, q)
        left = projected(J, gradient, at) / max(1.0, np.linalg.norm(gradient))
        if status is Status.CONVERGED and not case.clear:
            require(left <= 1.01 * TOLERANCE, f"CONVERGED with a projected gradient of {left:.3g}")
        if status is Status.REACHED and not case.clear:
            require(left > 0.5 * TOLERANCE, f"REACHED with a projected gradient of {left:.3g}")
    if status is Status.ITERATION_LIMIT:
        require(solution.iterations == problem.most, f"ITERATION_LIMIT after {solution.iterations}")
    if status in (Status.LOCAL_MINIMUM, Status.SINGULAR):
        everything = flatness(J, e, at)[0]
        flat = is_flat(everything, arm, q, problem.target)
        require(flat, f"{status.name} with a relative gradient of {everything:.3g}")
    if status is Status.LIMITS:
        everything, free = flatness(J, e, at)
        flat = is_flat(free, arm, q, problem.target)
        require(flat and 20 * everything > FLAT, f"LIMITS with relative gradients of {everything:.3g}, {free:.3g}")
    if status is Status.BLOCKED:
        require(case.clear, "BLOCKED without clearances")
        if case.clear:
            smallest = gaps(q, problem.centers).min()
            require(smallest <= SAFE + 2 * MARGIN + ROUNDING, f"BLOCKED {smallest:.3g} m from the nearest obstacle")
    if problem.kind == "unreachable" or (problem.kind == "target beyond limits" and arm.too_near):
        require(not on_target, f"{status.name} for an unreachable target")
    return found


def step_violations(case, arm, problem, ik):
    """Properties that single steps of a controller violate."""
    ik.reset()
    q, before = problem.q0, outside(arm.robot, problem.q0)
    for _ in range(4):
        q = ik.step(q, problem.target).q
        if not np.isfinite(q).all():
            return ["a step is not finite"]
        after = outside(arm.robot, q)
        if (after > before).any():
            return [f"a step goes {(after - before).max():.3g} farther outside the limits"]
        before = after
    return ["still outside the limits after four steps"] if after.any() else []


def clearance_violations(case, problem, trace):
    """Violations of clearances at the iterates and half-way between them."""
    q = trace.q
    start = gaps(q[0], problem.centers)
    allowed = np.minimum(start, SAFE) - ROUNDING - 1e-10 * len(q)
    sampled = np.vstack([q, (q[1:] + q[:-1]) / 2])
    worst = max((float((allowed - gaps(p, problem.centers)).max()) for p in sampled), default=0.0)
    return [f"a clearance {worst:.3g} m below its bound"] if worst > 0 else []


def build(case):
    arm = arm_of(case.arm)
    clearance = None
    if case.clear:
        field = [jtik.Circle(center, RADIUS) for center in FAR]
        clearance = jtik.Clearance(ObstacleAvoidance(field, bodies="links"), safe=SAFE, margin=MARGIN)
    return jtik.InverseKinematics(
        arm.robot,
        jtik.FrameTask("tip", arm.kind),
        criteria=CRITERIA[case.criterion][0](),
        strategy=case.strategy,
        solver=None if case.backend is None else BACKENDS[case.backend](),
        clearances=clearance,
    )


def sweep(case):
    """All violations of all problems of a case."""
    ik, arm, gradient_of = build(case), arm_of(case.arm), CRITERIA[case.criterion][1]
    for number, problem in enumerate(problems_of(case)):
        if case.clear:
            ik.parameters["clearance.centers"] = problem.centers
        options = {"q0": problem.q0, "max_iterations": problem.most, "until": problem.until, "trace": case.clear}
        solution = ik.solve(problem.target, **options)
        found = violations(case, arm, problem, solution, gradient_of)
        if case.clear:
            found += clearance_violations(case, problem, solution.trace)
        found += step_violations(case, arm, problem, ik)
        yield problem, solution, [f"{case}, problem {number} ({problem.kind}): {each}" for each in found]


PAIRS = sorted({(case.strategy, case.backend) for case in CASES}, key=str)


def is_quick(strategy, backend):
    """Whether a pair is among those that cover every strategy and every back end."""
    if backend in (None, "daqp"):
        return strategy in (*jtik.strategies, "hybrid+qp", "hybrid+second_order")
    return strategy in ("hybrid+qp", "weighted_qp")


def test_quick_pairs_cover_every_strategy_and_every_back_end():
    strategies, backends = zip(*(pair for pair in PAIRS if is_quick(*pair)), strict=True)
    assert set(strategies) >= set(jtik.strategies)
    assert set(backends) == {None, *BACKENDS}


def cases_of(strategy, backend):
    return [case for case in CASES if (case.strategy, case.backend) == (strategy, backend)]


def parts(pairs):
    """A quick pair has its first case in a quick run, and the others in a slow one; any other pair has all there."""
    for pair in pairs:
        cases = cases_of(*pair)
        if is_quick(*pair):
            yield pytest.param(*pair, cases[:1], id="-".join(map(str, pair)))
        if others := cases[is_quick(*pair) :]:
            yield pytest.param(*pair, others, id="-".join(map(str, (*pair, "others"))), marks=pytest.mark.slow)


def test_quick_cases_have_every_arm_every_criterion_and_clearances():
    quick = [cases_of(*pair)[0] for pair in PAIRS if is_quick(*pair)]
    assert {case.arm for case in quick} == set(BUILD)
    assert {case.criterion for case in quick} == set(CRITERIA)
    assert any(case.clear for case in quick)


@pytest.mark.quick(10)
@pytest.mark.parametrize(("strategy", "backend", "cases"), list(parts(PAIRS)))
def test_solutions_are_correct_and_within_limits(strategy, backend, cases):
    unsolved, found = 0, []
    for case in cases:
        for _, solution, violations_of_one in sweep(case):
            found += violations_of_one
            unsolved += solution.status is Status.UNSOLVED
    assert not found, "\n".join(found)
    if backend in (None, "daqp"):  # other back ends may report failure for nearly dependent rows
        assert unsolved <= (3 if strategy == "sns_qp" else 1)  # DAQP may fail with bounds within 1e-7 of the start


def test_there_are_two_thousand_problems_and_a_third_is_difficult():
    kinds = [problem.kind for case in CASES for problem in problems_of(case)]
    assert len(kinds) == PROBLEMS
    assert 0.32 <= 1 - kinds.count("generic") / PROBLEMS <= 0.35
    assert set(kinds) == {"generic", *DIFFICULT}
    assert {case.strategy for case in CASES} >= set(jtik.strategies)
    assert {case.backend for case in CASES} == {None, *BACKENDS}
    assert sum(case.clear for case in CASES) >= 10


class TestViolations:
    """The checks detect wrong answers."""

    CASE = Case("hybrid", None, "planar5", "centring", False)

    def found(self, problem=None, **wrong):
        arm = arm_of("planar5")
        goal = np.array([0.3, 0.4, -0.2, 0.5, 0.1])
        problem = problem or Problem("generic", goal, arm.pose(goal), FAR, "stationary")
        ik = build(self.CASE)
        solution = ik.solve(problem.target, q0=problem.q0, max_iterations=MAX_ITERATIONS)
        assert solution.converged
        assert not violations(self.CASE, arm, problem, solution, CRITERIA["centring"][1])
        return violations(self.CASE, arm, problem, replace(solution, **wrong), CRITERIA["centring"][1])

    def test_a_status_of_success_off_target_is_detected(self):
        wrong = np.array([0.3, 0.4, -0.2, 0.5, 0.2])
        assert any("CONVERGED at an error" in sentence for sentence in self.found(q=wrong))

    def test_a_status_of_failure_on_target_is_detected(self):
        assert any("LOCAL_MINIMUM at an error" in sentence for sentence in self.found(status=Status.LOCAL_MINIMUM))
        assert any(
            "REACHED with a projected" in sentence for sentence in self.found(status=Status.REACHED, converged=False)
        )

    def test_a_posture_that_is_not_stationary_is_detected(self):
        wrong = np.array([0.3, 0.4, -0.2, 0.5, 0.1])
        assert any("CONVERGED with a projected gradient" in sentence for sentence in self.found(q=wrong))

    def test_a_posture_outside_the_limits_or_not_finite_is_detected(self):
        assert any("outside its limits by 1.1" in sentence for sentence in self.found(q=np.full(5, 2.0)))
        assert self.found(q=np.full(5, np.nan)) == ["q is not finite"]
