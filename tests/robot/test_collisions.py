"""Which of a robot's own bodies can touch: the rule, its proofs, and changes by name."""

from __future__ import annotations

import functools
import pickle

import numpy as np
import pytest

import jtik
from jtik.robot import Joint, JointType, Mimic, Robot
from jtik.robot.collisions.frame_poses import frame_poses
from jtik.robot.collisions.reach import body_distances, is_out_of_reach
from jtik_formulations import SelfCollision

from ..conftest import EXACT, dh_arm, planar
from .conftest import make_mixed, pose

BALL = jtik.Sphere((0.0, 0.0, 0.0), 0.05)


def chain(*joints, shapes, **options):
    """A robot of joints (name, type, parent, child, options)."""
    return Robot([Joint(*joint[:4], **joint[4]) for joint in joints], shapes=shapes, base="base", **options)


def reasons(pairs):
    return {frozenset((pair.first, pair.second)): pair.left_out for pair in [*pairs.kept, *pairs.left_out]}


def test_poses_at_many_configurations_are_those_of_the_robot(rng):
    robot = make_mixed()
    q = np.array([robot.random_configuration(rng) for _ in range(20)])
    found = frame_poses(robot, q, robot.frame_names)
    for frame in robot.frame_names:
        for k, configuration in enumerate(q):
            expected = robot.pose(configuration, frame)
            assert np.broadcast_to(found[frame], (20, 4, 4))[k] == pytest.approx(expected, abs=EXACT)


def test_poses_of_frames_that_follow_a_mimic_joint(rng):
    joints = [
        Joint("a", JointType.PRISMATIC, "base", "a"),
        Joint("b", JointType.REVOLUTE, "a", "b", origin=pose((0.1, 0.2, 0.3)), mimic=Mimic("a", -2.0, 0.3)),
    ]
    robot = Robot(joints)
    q = np.array([[0.4], [-0.7]])
    for k in range(2):
        assert frame_poses(robot, q, ["b"])["b"][k] == pytest.approx(robot.pose(q[k], "b"), abs=EXACT)


class TestNeighbours:
    def test_bodies_beside_each_other_are_left_out_and_the_others_kept(self):
        pairs = planar(4).collision_pairs()
        assert [pair.name for pair in pairs] == [
            "link1-link2 and link3-link4",
            "link1-link2 and link4-tip",
            "link2-link3 and link4-tip",
        ]
        assert {pair.left_out for pair in pairs.left_out} == {"neighbours"}

    def test_a_fixed_joint_joins_two_frames_to_one_body(self):
        robot = chain(
            ("turn", JointType.REVOLUTE, "base", "arm", {}),
            ("bolt", JointType.FIXED, "arm", "plate", {"origin": pose((0.5, 0.0, 0.0))}),
            ("twist", JointType.REVOLUTE, "plate", "hand", {"origin": pose((0.5, 0.0, 0.0))}),
            shapes={"base": [BALL], "arm": [BALL], "plate": [BALL], "hand": [BALL]},
        )
        found = reasons(robot.collision_pairs())
        assert found[frozenset(("arm", "plate"))] == "no joint between them"
        for pair in (("base", "plate"), ("arm", "hand"), ("base", "arm")):
            assert found[frozenset(pair)] == "neighbours"

    @pytest.mark.parametrize(("away", "body", "reason"), [(0.0, False, True), (0.3, False, False), (0.0, True, False)])
    def test_joints_in_one_point_without_a_body_between_are_one_joint(self, away, body, reason):
        between = {"middle": [jtik.Sphere((0.0, 0.0, 0.4), 0.01)]} if body else {}
        robot = chain(
            ("first", JointType.REVOLUTE, "base", "middle", {}),
            ("offset", JointType.FIXED, "middle", "edge", {"origin": pose((away, 0.0, 0.0))}),
            ("second", JointType.REVOLUTE, "edge", "hand", {"axis": np.array([1.0, 0.0, 0.0])}),
            shapes={"base": [BALL], **between, "hand": [BALL]},
        )
        assert (reasons(robot.collision_pairs())[frozenset(("base", "hand"))] == "neighbours") == reason

    def test_two_fingers_on_one_hand_are_not_neighbours(self):
        sides = {"left": 0.1, "right": -0.1}
        robot = chain(
            *((side, JointType.PRISMATIC, "base", side, {"origin": pose((y, 0, 0)), "axis": np.array([1.0, 0, 0])})
              for side, y in sides.items()),
            shapes={side: [BALL] for side in sides},
            tip="left",
        )  # fmt: skip
        assert [pair.name for pair in robot.collision_pairs()] == ["left and right"]

    def test_links_of_a_wrist_in_one_point(self):
        """The link before three axes in one point and the link after them are beside each other."""
        lengths, twists = (0.4, 0.0, 0.0, 0.3, 0.3), (0.0, 1.5, -1.5, 0.0, 0.0)
        robot = Robot.from_dh([{"a": a, "alpha": alpha} for a, alpha in zip(lengths, twists, strict=True)])
        assert [pair.left_out for pair in robot.collision_pairs().left_out].count("neighbours") == 2


class TestProofs:
    @pytest.mark.quick(1)
    @pytest.mark.parametrize("seed", range(2))
    def test_what_is_never_near_is_far_at_every_sample(self, seed):
        rng = np.random.default_rng(seed)
        robot = dh_arm(5, seed, 1.0)
        pairs = robot.collision_pairs(within=0.02)
        never = [pair for pair in pairs.left_out if pair.left_out == "never within 0.02 m"]
        q = np.array([robot.random_configuration(rng) for _ in range(3000)])
        at_limits = rng.random(q.shape) < 0.3
        q = np.where(at_limits, np.where(rng.random(q.shape) < 0.5, robot.lower, robot.upper), q)
        for pair in never:
            bodies = (pairs.bodies[pair.first], pairs.bodies[pair.second])
            assert body_distances(robot, q, *bodies).min() > 0.02

    @pytest.mark.slow
    def test_some_pairs_of_the_panda_never_come_near_and_none_does(self, rng):
        robot = jtik.Robot.builtin("panda")
        pairs = robot.collision_pairs()
        never = [pair for pair in pairs.left_out if str(pair.left_out).startswith("never")]
        assert len(never) > 10
        q = np.array([robot.random_configuration(rng) for _ in range(2000)])
        for pair in never:
            assert body_distances(robot, q, pairs.bodies[pair.first], pairs.bodies[pair.second]).min() > 0.02

    @pytest.mark.parametrize("gap", [0.019, 0.022])
    def test_the_smallest_distance_decides(self, gap):
        """A ball on a crank passes another at one angle, where random configurations hardly look."""
        radius = 0.01
        robot = chain(
            ("lift", JointType.PRISMATIC, "base", "lift", {"lower": -1.0, "upper": 1.0}),
            ("turn", JointType.REVOLUTE, "lift", "crank", {"lower": -3.0, "upper": 3.0}),
            shapes={
                "base": [jtik.Sphere((1 + 2 * radius + gap, 0.0, 0.7), radius)],
                "crank": [jtik.Sphere((1.0, 0.0, 0.0), radius)],
                "lift": [jtik.Sphere((0.0, 0.0, 0.0), radius)],
            },
        )
        pairs = robot.collision_pairs()
        a, b = (next(body for body in pairs.bodies.values() if body.name == name) for name in ("base", "crank"))
        assert is_out_of_reach(robot, a, b, 0.02) == (gap > 0.02)
        assert (reasons(pairs)[frozenset(("base", "crank"))] is None) == (gap < 0.02)

    def test_a_joint_without_limits_turns_all_the_way_round(self):
        robot = chain(
            ("lift", JointType.PRISMATIC, "base", "lift", {"lower": 0.0, "upper": 0.1}),
            ("turn", JointType.REVOLUTE, "lift", "crank", {}),
            shapes={"base": [jtik.Sphere((-1.0, 0.0, 0.05), 0.01)], "crank": [jtik.Sphere((1.0, 0.0, 0.0), 0.01)]},
        )
        pairs = robot.collision_pairs()
        assert not is_out_of_reach(robot, *pairs.bodies.values(), 0.02)
        assert is_out_of_reach(robot.with_base(np.eye(4)), *pairs.bodies.values(), -0.5)

    def test_a_prismatic_joint_without_limits_proves_nothing(self):
        robot = chain(
            ("slide", JointType.PRISMATIC, "base", "slide", {}),
            ("turn", JointType.REVOLUTE, "slide", "crank", {"origin": pose((0.0, 0.0, 50.0))}),
            shapes={"base": [BALL], "crank": [BALL]},
        )
        assert not is_out_of_reach(robot, *robot.collision_pairs().bodies.values(), 0.02)


def test_capsules_that_are_thicker_than_the_bodies_are_left_out():
    """They touch at most configurations; the same ones, thin, are kept."""

    def arm(radius):
        return chain(
            ("first", JointType.REVOLUTE, "base", "one", {}),
            ("second", JointType.REVOLUTE, "one", "two", {"origin": pose((0.2, 0.0, 0.0))}),
            ("third", JointType.REVOLUTE, "two", "three", {"origin": pose((0.2, 0.0, 0.0))}),
            shapes={
                name: [jtik.Capsule((0.0, 0.0, 0.0), (0.2, 0.0, 0.0), radius)] for name in ("one", "two", "three")
            },
        )  # fmt: skip

    thin, thick = (reasons(arm(radius).collision_pairs())[frozenset(("one", "three"))] for radius in (0.01, 0.15))
    assert (thin, thick) == (None, "often touching")


@functools.cache
def panda():
    return jtik.Robot.builtin("panda")


class TestNames:
    def test_a_frame_means_all_its_solids_and_a_number_one_of_them(self):
        robot = panda()
        whole = robot.collision_pairs(exclude=[("panda_hand", "panda_link5")])
        one = robot.collision_pairs(exclude=[("panda_link5[0]", "panda_hand[1]")])
        assert len(robot.collision_pairs()) - len(whole) == 4
        assert len(robot.collision_pairs()) - len(one) == 1
        assert reasons(one)[frozenset(("panda_link5[0]", "panda_hand[1]"))] == "excluded"
        assert [pair.name for pair in one] == [pair.name for pair in robot.collision_pairs() if pair in one.kept]

    def test_one_name_means_all_pairs_with_it(self):
        pairs = panda().collision_pairs(exclude=["panda_hand"])
        assert not [pair for pair in pairs if "panda_hand" in pair.name]

    def test_a_pair_that_is_included_is_kept(self):
        pairs = panda().collision_pairs(include=[("panda_link5[1]", "panda_link7")])
        assert len(pairs) == len(panda().collision_pairs()) + 1
        assert "panda_link5[1] and panda_link7" in [pair.name for pair in pairs]

    def test_unknown_names_are_refused(self):
        with pytest.raises(jtik.UnknownNameError, match="unknown body 'panda_link99'; did you mean 'panda_link"):
            panda().collision_pairs(exclude=[("panda_link99", "panda_hand")])

    def test_a_pair_cannot_be_excluded_and_included(self):
        with pytest.raises(jtik.ArgumentError, match=r"include: given .*panda_link7.*; accepted: pairs that exclude"):
            panda().collision_pairs(exclude=["panda_link7"], include=[("panda_link5", "panda_link7")])

    @pytest.mark.parametrize("wrong", ["panda_hand", [1], [("a", "b", "c")], [()], 3, [("panda_hand", 2)]])
    def test_what_names_no_pair_is_refused(self, wrong):
        with pytest.raises(jtik.ArgumentError, match="exclude: given .*; accepted: pairs of names"):
            panda().collision_pairs(exclude=wrong)

    @pytest.mark.parametrize("argument", ["exclude", "include"])
    def test_a_body_and_itself_are_no_pair(self, argument):
        with pytest.raises(
            jtik.ArgumentError, match=rf"{argument}: given .*; accepted: two different .*\['panda_hand'\]"
        ):
            panda().collision_pairs(**{argument: [("panda_hand", "panda_hand")]})
        with pytest.raises(jtik.ArgumentError, match=f"{argument}: given .*; accepted: .* two bodies on different"):
            planar(4).collision_pairs(bodies="links", **{argument: [("link1-link2", "link1")]})

    def test_solids_of_a_robot_that_has_none(self):
        with pytest.raises(jtik.ArgumentError, match="bodies: given 'shapes' on Robot.*; accepted: 'links'"):
            planar(3).collision_pairs(bodies="shapes")


class TestTable:
    def test_it_shows_every_pair_and_every_reason(self):
        text = str(panda().collision_pairs(exclude=["panda_link0"]))
        lines = text.splitlines()
        assert lines[0].split("  ")[0] == "pairs that can touch"
        pairs = panda().collision_pairs(exclude=["panda_link0"])
        assert all(any(line.startswith(pair.name) for line in lines) for pair in pairs)
        assert f"left out, excluded ({len([p for p in pairs.left_out if p.left_out == 'excluded'])}): " in text
        assert "left out, neighbours (" in text
        assert "left out, often touching (1): panda_link5[1] and panda_link7" in text

    def test_its_figures_are_distances_at_home(self):
        robot = panda()
        pairs = robot.collision_pairs()
        for pair in pairs:
            bodies = (pairs.bodies[pair.first], pairs.bodies[pair.second])
            assert pair.at_home == pytest.approx(body_distances(robot, robot.home[None], *bodies)[0], abs=EXACT)

    def test_it_is_the_same_for_the_same_robot_built_again(self):
        assert str(jtik.Robot.builtin("panda").collision_pairs()) == str(panda().collision_pairs())


class TestDisabled:
    DISABLED = {("panda_link0", "panda_link5"): "never", ("panda_hand", "panda_link4"): ""}  # noqa: RUF012

    def robot(self):
        full = panda()
        return Robot(full.joints, shapes=full.shapes, tip="tip", base=full.base, disabled_collisions=self.DISABLED)

    def test_disabled_pairs_are_left_out_in_either_order(self):
        left_out = [pair.left_out for pair in self.robot().collision_pairs().left_out]
        assert (left_out.count("disabled (never)"), left_out.count("disabled")) == (2, 2)

    def test_variants_and_copies_keep_them(self):
        robot = self.robot()
        for variant in (
            pickle.loads(pickle.dumps(robot)),
            robot.subset(robot.joint_names[:4]),
            robot.with_base(np.eye(4)),
            robot.with_tool(np.eye(4)),
        ):
            assert variant.disabled_collisions == self.DISABLED

    def test_a_tool_renames_the_frame_tip(self):
        robot = Robot(
            [Joint("a", JointType.REVOLUTE, "base", "tip")], disabled_collisions={("base", "tip"): "adjacent"}
        )
        assert robot.with_tool(np.eye(4)).disabled_collisions == {("base", "flange"): "adjacent"}

    def test_they_are_read_only(self):
        with pytest.raises(TypeError):
            self.robot().disabled_collisions["panda_link0", "panda_link1"] = ""

    @pytest.mark.parametrize("wrong", [[("a", "b")], {("base",): ""}, {("base", "link1"): 3}, {"base": ""}])
    def test_wrong_values_are_refused(self, wrong):
        with pytest.raises(jtik.ArgumentError, match="disabled_collisions: given"):
            Robot(planar(2).joints, planar=True, disabled_collisions=wrong)

    def test_unknown_frames_are_refused(self):
        with pytest.raises(jtik.UnknownNameError, match="frame 'hand'"):
            Robot(planar(2).joints, planar=True, disabled_collisions={("base", "hand"): ""})


def test_locked_joints_make_one_body_of_two():
    robot = panda().subset(panda().joint_names[:2])
    found = reasons(robot.collision_pairs())
    assert found[frozenset(("panda_link4", "panda_hand[0]"))] == "no joint between them"


def test_the_criterion_has_the_pairs_of_the_robot():
    names = [f"{pair.first} to {pair.second}" for pair in panda().collision_pairs(exclude=["panda_hand"])]
    assert SelfCollision(exclude=["panda_hand"]).pair_names(panda()) == names
