"""The collection: known solutions against independent oracles."""

from __future__ import annotations

import functools

import numpy as np
import pytest
from scipy.optimize import linprog, minimize

import jtik
from jtik import problems

from ..conftest import planar_jacobian, planar_points
from .conftest import ARRIVED, distance_to, inside, mujoco_jacobian, mujoco_pose

named = functools.cache(problems.named)


def known(case, name, count):
    return np.array([case.known[f"{name}_{i}"] for i in range(1, count + 1)])


@pytest.mark.quick(5)
@pytest.mark.parametrize("name", problems.names())
def test_every_problem_of_the_collection_is_valid_and_has_a_source(name):
    entry = named(name)
    entry.problems.check(entry.robot, entry.task)
    assert entry.name == name
    assert entry.origin
    assert all(case.origin and case.reachable is not None and "error" in case.known for case in entry.problems)
    assert problems.ProblemSet.from_data(entry.problems.as_data()) == entry.problems
    assert name in repr(entry)


@pytest.mark.quick(4)
@pytest.mark.parametrize("name", [name for name in problems.names() if name != "das1988_families"])
def test_every_reachable_target_is_reached_according_to_mujoco(name):
    entry = named(name)
    ik = jtik.InverseKinematics(entry.robot, entry.task)
    for case in entry.problems:
        q = case.q0
        for target in case.targets if case.reachable else ():
            q = ik.solve(target, q0=q, restarts=60, until="reached").q
            assert inside(entry.robot, q)
            assert distance_to(entry.robot, q, target, entry.task.kind) < ARRIVED


def test_an_unknown_name_is_refused_with_the_closest_one():
    with pytest.raises(jtik.UnknownNameError, match="did you mean 'sns_4r'"):
        problems.named("sns_4")


def test_the_saturated_velocity_has_the_largest_task_scale_and_minimum_norm():
    entry = named("sns_4r")
    limit = entry.robot.velocity_limit
    for case in entry.problems:
        J, wanted = planar_jacobian(case.q0), case.target - planar_points(case.q0)[-1]
        rows = np.column_stack([J, -wanted])
        bounds = [*((-each, each) for each in limit), (0, 1)]
        most = linprog([0, 0, 0, 0, -1], A_eq=rows, b_eq=[0, 0], bounds=bounds)
        assert case.known["scale"] == pytest.approx(-most.fun, abs=1e-9)
        solution = minimize(
            lambda dq: dq @ dq / 2,
            most.x[:4],
            jac=lambda dq: dq,
            method="SLSQP",
            bounds=bounds[:4],
            constraints={
                "type": "eq",
                "fun": lambda dq, J=J, x=wanted * -most.fun: J @ dq - x,
                "jac": lambda dq, J=J: J,
            },
        )
        assert known(case, "dq", 4) == pytest.approx(solution.x, abs=1e-6)
        assert case.dt == 1.0


def test_an_unsaturated_velocity_would_break_two_limits():
    case = named("sns_4r").problems[0]
    free = np.linalg.pinv(planar_jacobian(case.q0)) @ (case.target - planar_points(case.q0)[-1])
    assert (np.abs(free) > named("sns_4r").robot.velocity_limit).tolist() == [True, True, False, False]


def test_the_transpose_step_is_the_exact_line_search_of_the_linear_model():
    case = named("transpose_step_2r").problems[0]
    J, e = planar_jacobian(case.q0), planar_points(case.q0)[-1] - case.target
    best = minimize(lambda a: ((e - a[0] * J @ J.T @ e) ** 2).sum() / 2, [0.1], tol=1e-12)
    assert case.known["alpha"] == pytest.approx(best.x[0], abs=1e-6)
    assert case.known["predicted_V"] == pytest.approx(best.fun, abs=1e-9)
    assert known(case, "dq", 2) == pytest.approx(-case.known["alpha"] * J.T @ e, abs=1e-12)
    assert case.known["V"] == pytest.approx(e @ e / 2)
    after = planar_points(case.q0 + known(case, "dq", 2))[-1] - case.target
    assert case.known["V_after"] == pytest.approx(after @ after / 2, abs=1e-12)


def test_the_null_projection_is_that_of_the_pseudo_inverse():
    entry = named("null_projector_3r")
    case = entry.problems[0]
    J = planar_jacobian(case.q0)
    projected = (np.eye(3) - np.linalg.pinv(J) @ J) @ np.ones(3)
    assert known(case, "null", 3) == pytest.approx(projected, abs=1e-12)
    start = jtik.InverseKinematics(entry.robot, entry.task, criteria=entry.criteria).solve(
        case.target, q0=case.q0, max_iterations=0
    )
    assert start.gradient == pytest.approx(np.ones(3), abs=1e-12)
    assert start.null_space_residual == pytest.approx(case.known["null_norm"], abs=1e-12)
    assert start.cost == pytest.approx(case.known["H_start"], abs=1e-12)


def test_no_posture_on_the_target_has_less_H_than_the_known_optimum():
    entry = named("centering_3r")
    case = entry.problems[0]
    preferred = entry.criteria.parameters(entry.robot)["preferred"]
    best = known(case, "q", 3)
    assert planar_points(best)[-1] == pytest.approx(case.target, abs=1e-12)
    assert case.known["H"] == pytest.approx(((best - preferred) ** 2).sum() / 2, abs=1e-12)
    # all solutions: angle of the last link, both elbow solutions of the other two, closest multiples of a full turn
    smallest = np.inf
    for heading in np.linspace(-np.pi, np.pi, 20001):
        x, y = case.target - [np.cos(heading), np.sin(heading)]
        cosine = (x * x + y * y - 2) / 2
        for elbow in (np.arccos(cosine), -np.arccos(cosine)) if abs(cosine) <= 1 else ():
            first = np.arctan2(y, x) - np.arctan2(np.sin(elbow), 1 + np.cos(elbow))
            away = np.array([first, elbow, heading - first - elbow]) - preferred
            away -= 2 * np.pi * np.round(away / (2 * np.pi))
            smallest = min(smallest, away @ away / 2)
    assert smallest == pytest.approx(case.known["H"], abs=1e-6)
    assert smallest >= case.known["H"] - 1e-12


def test_slsqp_finds_the_same_optimum():
    entry = named("centering_3r")
    preferred = entry.criteria.parameters(entry.robot)["preferred"]
    for case in entry.problems:
        found = minimize(
            lambda q: ((q - preferred) ** 2).sum() / 2,
            case.q0,
            method="SLSQP",
            constraints={"type": "eq", "fun": lambda q, x=case.target: planar_points(q)[-1] - x},
            options={"ftol": 1e-14, "maxiter": 200},
        )
        assert found.fun >= case.known["H"] - 1e-9
        if case is entry.problems[0]:
            assert found.x == pytest.approx(known(case, "q", 3), abs=1e-5)


def test_a_straight_arm_has_no_gradient_for_a_target_on_its_line():
    for case in named("straight_10r").problems:
        J = planar_jacobian(case.q0)
        assert np.abs(J.T @ (planar_points(case.q0)[-1] - case.target)).max() == 0
        assert np.linalg.svd(J, compute_uv=False)[-1] == case.known["sigma_min"] == 0


def test_the_other_elbow_solution_violates_a_limit():
    entry = named("elbow_2r")
    for case in entry.problems:
        q = known(case, "q", 2)
        assert planar_points(q)[-1] == pytest.approx(case.target, abs=1e-12)
        other = np.array([q[0] + q[1], -q[1]])
        assert planar_points(other)[-1] == pytest.approx(case.target, abs=1e-12)
        assert other[1] < entry.robot.lower[1] < q[1] < entry.robot.upper[1]
        assert (case.q0 >= entry.robot.lower).all()
        assert (case.q0 <= entry.robot.upper).all()


def test_no_search_finds_a_smaller_error_for_an_unreachable_target():
    for case in named("unreachable_10r").problems:
        found = minimize(lambda q, x=case.target: np.sum((planar_points(q)[-1] - x) ** 2), case.q0, tol=1e-12)
        assert np.sqrt(found.fun) == pytest.approx(case.known["error"], abs=1e-6)
        heading = np.arctan2(case.target[1], case.target[0])
        assert np.linalg.norm(10 * np.array([np.cos(heading), np.sin(heading)]) - case.target) == pytest.approx(0.5)


@pytest.mark.parametrize("name", ["circle_3r", "circle_10r", "circle_panda"])
def test_the_circles_are_round_closed_and_begin_at_the_start(name):
    entry = named(name)
    size = entry.robot.dimension
    for case in entry.problems:
        path = np.array([target[:size, 3] if target.ndim == 2 else target for target in case.targets])
        assert path[0] == pytest.approx(mujoco_pose(entry.robot, case.q0)[:size, 3], abs=1e-9)
        radii = np.linalg.norm(path - path[:-1].mean(axis=0), axis=1)
        assert radii == pytest.approx(case.known["size"], abs=1e-12)
        assert case.closed
        assert np.array_equal(case.targets[0], case.targets[-1])


@pytest.mark.parametrize("name", ["ur5e_wrist", "panda_stretched"])
def test_singular_starts_are_singular_by_mujoco(name):
    entry = named(name)
    for case in entry.problems:
        angle = float(abs(case.q0[4]))  # of the joint that makes it singular at zero
        sigma = np.linalg.svd(mujoco_jacobian(entry.robot, case.q0), compute_uv=False)
        assert sigma[-1] <= max(1e-12, angle)
        assert sigma[-2] > 0.01
        assert ("sigma_min" in case.known) is (angle == 0)
        assert (sigma[-1] > 1e-3 * angle) or angle == 0
        assert inside(entry.robot, case.q0)


class TestFiveFamilies:
    def test_there_are_two_hundred_of_each_of_six_kinds(self):
        made = named("das1988_families").problems
        assert len(made) == 1200
        assert [len(made.of(kind)) for kind in made.kinds] == [200] * 6
        assert len(problems.five_families(3)) == 18
        assert problems.five_families(3).of("far").cases == made.of("far")[:3].cases

    def test_targets_and_starts_match_their_family(self):
        made = named("das1988_families").problems
        distance = {kind: [np.linalg.norm(case.target) for case in made.of(kind)] for kind in made.kinds}
        start = {kind: np.abs([case.q0 for case in made.of(kind)]) for kind in made.kinds}
        assert np.array(distance["boundary 9.999"]) == pytest.approx(9.999, abs=1e-12)
        assert np.array(distance["unreachable 10.5"]) == pytest.approx(10.5, abs=1e-12)
        assert max(distance["generic"] + distance["far"]) < 10
        assert all(case.target[1] == 0 and 3 < case.target[0] < 9 for case in made.of("near-straight 1e-6"))
        assert start["generic"].max() < 1 < start["far"].max() < np.pi
        assert start["near-straight 1e-3"].std() == pytest.approx(6e-4, rel=0.1)

    def test_the_smallest_errors_are_those_of_a_straight_arm(self):
        for case in problems.five_families(5):
            assert case.known["error"] == pytest.approx(max(0, np.linalg.norm(case.target) - 10), abs=1e-12)
            assert case.reachable is (case.known["error"] == 0)

    def test_the_first_problem_is_that_of_the_published_table(self):
        # the figures of papers/das1988 belong to these problems
        generator = np.random.default_rng([1988, 0, 0])
        case = problems.five_families(1)[0]
        assert (case.q0 == generator.uniform(-1, 1, 10)).all()
        assert case.target == pytest.approx(planar_points(generator.uniform(-1, 1, 10))[-1], abs=1e-14)

    @pytest.mark.parametrize("count", [0, 1.5, "many"])
    def test_an_invalid_count_is_refused(self, count):
        with pytest.raises(jtik.ArgumentError, match="count"):
            problems.five_families(count)
