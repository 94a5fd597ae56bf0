"""Configurations of the full robot, and dicts by joint name, where a solver takes those of the reduced one."""

from __future__ import annotations

import numpy as np
import pytest

import jtik

from ..conftest import shared_solver

PANDA = jtik.Robot.builtin("panda")
HOME = PANDA.keyframes["home"]
MOVED = [f"panda_joint{i}" for i in (1, 2, 4)]
TARGET = PANDA.position(HOME) + np.array([0.02, 0.05, -0.03])


@pytest.fixture
def ik():
    return shared_solver(PANDA, jtik.FrameTask("tip", "position"), joints=MOVED, at=HOME, strategy="damped+qp")


def forms(ik, q):
    """The same configuration in each form that is accepted."""
    return {
        "reduced": q,
        "list": q.tolist(),
        "full": ik.full_configuration(q),
        "dict": dict(zip(MOVED, q.tolist(), strict=True)),
    }


@pytest.mark.parametrize("form", ["list", "full", "dict"])
class TestEveryMethod:
    Q = HOME[[0, 1, 3]] + np.array([0.1, -0.1, 0.2])

    def test_solve(self, ik, form):
        q0 = forms(ik, self.Q)
        assert ik.solve(TARGET, q0=q0[form]).q.tolist() == ik.solve(TARGET, q0=q0["reduced"]).q.tolist()

    def test_step(self, ik, form):
        q = forms(ik, self.Q)
        expected = ik.step(q["reduced"], TARGET).q.tolist()
        ik.reset()
        assert ik.step(q[form], TARGET).q.tolist() == expected
        expected = ik.step(q["reduced"], TARGET, dt=0.01).q.tolist()
        ik.reset()
        assert ik.step(q[form], TARGET, dt=0.01).q.tolist() == expected

    def test_track(self, ik, form):
        q0 = forms(ik, self.Q)
        assert ik.track([TARGET], q0=q0[form]).q.tolist() == ik.track([TARGET], q0=q0["reduced"]).q.tolist()

    def test_build(self, form):
        criteria = jtik.criteria["joint_centering"]()
        ik = shared_solver(
            PANDA,
            jtik.FrameTask("tip", "position"),
            joints=MOVED,
            at=HOME,
            strategy="newton+qp",
            criteria=criteria,
        )
        q = forms(ik, self.Q)
        assert ik.build(q[form], TARGET).q.tolist() == ik.build(q["reduced"], TARGET).q.tolist()

    def test_full_configuration(self, ik, form):
        q = forms(ik, self.Q)
        assert ik.full_configuration(q[form]).tolist() == ik.full_configuration(q["reduced"]).tolist()

    def test_solve_batch(self, ik, form):
        starts = [self.Q, self.Q + 0.05]
        expected = ik.solve_batch([TARGET, TARGET], q0=np.array(starts)).q.tolist()
        assert ik.solve_batch([TARGET, TARGET], q0=[forms(ik, q)[form] for q in starts]).q.tolist() == expected
        one = ik.solve_batch([TARGET, TARGET], q0=forms(ik, self.Q)[form])
        assert one.q.tolist() == ik.solve_batch([TARGET, TARGET], q0=self.Q).q.tolist()


class TestWrongInput:
    def test_a_wrong_length_names_both_lengths(self, ik):
        for call, name in (
            (lambda: ik.solve(TARGET, q0=np.zeros(5)), "q0"),
            (lambda: ik.step(np.zeros(5), TARGET), "q"),
            (lambda: ik.track([TARGET], q0=np.zeros(5)), "q0"),
            (lambda: ik.solve_batch([TARGET], q0=[np.zeros(5)]), r"q0\[0\]"),
        ):
            with pytest.raises(jtik.ArgumentError, match=rf"^{name}: given shape \(5,\); accepted: .*3.*{PANDA.nq}"):
                call()

    def test_an_unknown_joint(self, ik):
        with pytest.raises(jtik.JtikError, match="unknown joint in q0 'elbow'"):
            ik.solve(TARGET, q0={"elbow": 0.3})

    def test_another_number_of_starts(self, ik):
        with pytest.raises(
            jtik.ArgumentError,
            match=r"q0: given 2 configurations; accepted: one configuration of shape \(3,\) for all targets, or 1",
        ):
            ik.solve_batch([TARGET], q0=np.zeros((2, 3)))


class TestUnused:
    """The part of a target that a task does not use is on the Solution."""

    POSE = PANDA.pose(HOME + 0.05)

    def test_the_orientation_of_a_pose_for_a_position_task(self):
        ik = shared_solver(PANDA, jtik.FrameTask("tip", "position"))
        solution = ik.solve(self.POSE, q0=HOME)
        assert solution.converged
        assert solution.unused == "orientation of the target"
        assert repr(solution).endswith("\n  not used    orientation of the target")
        assert ik.solve_batch([self.POSE], q0=HOME)[0].unused == "orientation of the target"

    def test_several_tasks_are_named(self):
        tasks = [jtik.FrameTask("tip", "position", name="hand"), jtik.FrameTask("panda_link4", name="elbow")]
        ik = shared_solver(PANDA, tasks)
        solution = ik.solve({"hand": self.POSE, "elbow": (0.0, 0.1, 0.6)}, q0=HOME)
        assert solution.unused == "hand: orientation of the target"

    def test_none_where_all_is_used(self):
        for task, target in (
            (jtik.FrameTask("tip", "position"), self.POSE[:3, 3]),
            (jtik.FrameTask("tip", "pose"), self.POSE),
        ):
            solution = shared_solver(PANDA, task).solve(target, q0=HOME)
            assert solution.unused is None
            assert "not used" not in repr(solution)
