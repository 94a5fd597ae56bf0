"""Feasibility restoration: its quadratic program against closed forms, and what it accepts, remembers and reports."""

from __future__ import annotations

import casadi
import numpy as np
import pytest
import qpsolvers

import jtik
from jtik.constraints.clearance import ClearanceModel, lacking
from jtik.constraints.motion_bound import MotionBound
from jtik.qp import QPRecorder
from jtik.robot import Joint, JointType
from jtik.strategy.feasibility_restoration import LONGEST, FeasibilityRestoration, feasibility_restoration
from jtik.symbolic import substitute

from .conftest import numbers

SAFE, AIM = 0.1, 0.2
C = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 1.0]])
TASK = np.array([[1.0, 0.0, 0.0]])
"""The task moves with the first joint only."""

PRISMATIC = jtik.Robot(
    [Joint(f"joint{i}", JointType.PRISMATIC, f"frame{i}", f"frame{i + 1}") for i in range(3)], base="frame0"
)
"""No point moves farther than the joints."""

FINITE = 1e-5
"""A demand of 0.1 m is missed by 3e-5 of it, because its penalty weight is finite."""


def clearances(distance, *, restored=(True, True), gain=1.0, longest=LONGEST, record=1e300, keeps=1):
    """Distances that are linear in dq, along a path that is safe where ``keeps`` is 1."""
    distance, k = casadi.SX(distance), len(distance)
    restored = np.array(restored)

    def path(dq):
        after = distance + casadi.SX(C) @ dq
        return keeps, casadi.sum1(lacking(after, SAFE, AIM, casadi.SX(restored.astype(float))))

    return ClearanceModel(
        distance=distance,
        jacobian=casadi.SX(C),
        safe=casadi.SX([SAFE] * k),
        aim=casadi.SX([AIM] * k),
        influence=casadi.SX([1.0] * k),
        gain=casadi.SX([gain] * k),
        curvature_radius=casadi.SX(1e9),
        motion=MotionBound(PRISMATIC, casadi.SX(3, 1)),
        path=path,
        restored=restored,
        longest=casadi.SX(longest),
        smallest_violation=casadi.SX(record),
    )


def restored(model, box=1.0):
    """The restoration at the target, its quadratic program solved by DAQP."""
    qps, box = QPRecorder(1e-7), np.broadcast_to(box, 3)
    bounds = casadi.SX(-box), casadi.SX(box)
    made = feasibility_restoration(model, qps, bounds, lambda: casadi.SX(TASK), casadi.SX(TASK), casadi.SX(0))
    values = []
    for preparation in qps.preparations:
        data = casadi.Function("data", [], preparation.solution.qp.data())  # has calls of functions in it
        P, q, A, low, high, lower, upper = map(np.array, data.call([]))
        x = np.zeros(3)
        if numbers(preparation.needed):
            assert np.isinf(high).all()
            x = qpsolvers.solve_qp(
                P, q[:, 0], -A, -low[:, 0], lb=lower[:, 0], ub=upper[:, 0], solver="daqp", primal_tol=1e-10
            )
        values += [casadi.DM(substitute(result, preparation.solution.x, x)) for result in preparation.results]
    dq, gained = values or (made.dq, made.gained)
    return FeasibilityRestoration(
        casadi.SX(dq), casadi.SX(gained), made.clearance, made.jacobian, made.length, made.smallest_violation
    )


class TestDisplacement:
    def test_nothing_is_done_where_all_distances_are_large_enough(self):
        found = restored(clearances([AIM, 0.17]))  # half of the margin is tolerated
        assert numbers(found.dq).tolist() == [0, 0, 0]
        assert not numbers(found.pending)

    def test_the_shortest_displacement_outside_the_task_meets_the_demand(self):
        found = restored(clearances([0.5, 0.1]))
        assert numbers(found.dq) == pytest.approx([0, 0.05, 0.05], abs=FINITE)
        assert numbers(found.gained)[1] == pytest.approx(0.1, abs=FINITE)

    def test_the_gain_is_the_share_of_the_demand(self):
        assert numbers(restored(clearances([0.5, 0.1], gain=0.5)).gained)[1] == pytest.approx(0.05, abs=FINITE)

    def test_a_demand_that_needs_the_task_moves_the_task(self):
        assert numbers(restored(clearances([0.1, 0.5])).dq) == pytest.approx([0.1, 0, 0], abs=FINITE)

    def test_limits_and_the_longest_motion_bound_it(self):
        assert numbers(restored(clearances([0.5, -9.0]), box=[1, 0.1, 0.2]).dq) == pytest.approx([0, 0.1, 0.2])
        assert numbers(restored(clearances([0.5, -9.0], longest=0.05)).dq) == pytest.approx([0, 0.05, 0.05])

    @pytest.mark.parametrize("longest", [LONGEST, LONGEST / 2, LONGEST / 4, LONGEST / 64])
    def test_within_the_margin_the_demand_falls_with_the_square_of_the_longest_motion(self, longest):
        """A refused step shortens the restoration faster than itself: at last the task can fall again."""
        share = (longest / LONGEST) ** 2
        found = restored(clearances([0.14, 0.5], longest=longest))
        assert numbers(found.clearance.demand) == pytest.approx([0.06 * share, 0])
        below = restored(clearances([0.09, 0.5], longest=longest))
        assert numbers(below.clearance.demand) == pytest.approx([0.11, 0])

    def test_clearances_that_are_not_restored_need_no_quadratic_program(self):
        found = restored(clearances([0.05, 0.05], restored=(False, False)))
        assert found.dq.is_zero()
        assert found.accepts(casadi.SX(3, 1), casadi.SX(0)) == 0

    @pytest.mark.parametrize("distance", [[0.5, 0.1], [0.05, -9.0], [0.3, 0.3]])
    def test_it_satisfies_the_rows_that_it_leaves(self, distance):
        found = restored(clearances(distance), box=0.2)
        rows = found.rows
        low, value = numbers(rows.lower), C @ numbers(found.dq)
        assert (low <= value + 1e-9).all()
        assert np.isposinf(numbers(rows.upper)).all()

    def test_into_a_smaller_box_it_is_shortened_as_a_whole(self):
        found = restored(clearances([0.5, 0.1]))
        shorter = found.within(casadi.SX([-1.0, -1, -1]), casadi.SX([1.0, 0.01, 1]))
        assert numbers(shorter.dq) == pytest.approx([0, 0.01, 0.01], abs=FINITE)
        assert numbers(shorter.gained)[1] == pytest.approx(0.02, abs=FINITE)


class TestAcceptance:
    """The restoration promises an increase of the second distance by 0.1."""

    def accepts(self, dq, length=0.0, **options):
        found = restored(clearances([0.5, 0.1], **options))
        return bool(numbers(found.accepts(casadi.SX(dq), casadi.SX(length))))

    def test_the_displacement_itself(self):
        assert self.accepts([0, 0.05, 0.05])

    def test_a_tenth_of_the_promised_gain_is_needed(self):
        """A violation ends where the distance is larger than 0.15; before that it falls with the distance."""
        assert self.accepts([0, 0.0051, 0.0051])
        assert not self.accepts([0, 0.0049, 0.0049])
        assert not self.accepts([0, -0.05, -0.05])

    def test_only_what_is_below_the_smallest_violation_so_far_counts(self):
        assert not self.accepts([0, 0.01, 0.01], record=0.05)
        assert self.accepts([0, 0.05, 0.05], record=0.05)

    def test_the_error_may_rise_no_more_than_the_restoration_explains(self):
        explained = 0.05**2 + 0.05**2  # |J| |dq|^2; to first order the task does not move
        assert self.accepts([0, 0.05, 0.05], length=0.99 * explained)
        assert not self.accepts([0, 0.05, 0.05], length=1.01 * explained)

    def test_where_nothing_is_demanded_nothing_is_accepted_for_it(self):
        found = restored(clearances([0.5, 0.5]))
        assert not numbers(found.accepts(casadi.SX([0, 0.1, 0.1]), casadi.SX(0)))


class TestMemory:
    def after(self, accepted, dq=(0, 0.05, 0.05), **options):
        found = restored(clearances([0.5, 0.0999], **options))
        return {name: numbers(value) for name, value in found.after(casadi.SX(list(dq)), accepted).items()}

    def test_an_accepted_step_doubles_the_longest_motion_up_to_a_bound(self):
        assert self.after(1, longest=0.1)["longest"] == pytest.approx(0.2)
        assert self.after(1, longest=0.2)["longest"] == pytest.approx(LONGEST)

    def test_a_refused_step_divides_it_by_four_unless_another_part_is_at_fault(self):
        assert self.after(0, longest=0.1, keeps=1)["longest"] == pytest.approx(0.025)
        assert self.after(0, longest=0.1, keeps=0)["longest"] == pytest.approx(0.025)
        assert self.after(0, dq=(0.9, 0.05, 0.05), longest=0.1, keeps=0)["longest"] == pytest.approx(0.1)

    def test_the_smallest_violation_is_kept(self):
        assert self.after(1)["violation"] == pytest.approx(0.0, abs=FINITE)
        assert self.after(0)["violation"] == pytest.approx(0.1001)
        assert self.after(1, dq=(0, 0, 0), record=0.02)["violation"] == pytest.approx(0.02)


class TestReport:
    def test_what_cannot_be_restored_is_missing(self):
        blocked = restored(clearances([0.5, 0.05]), box=[1, 0, 0])
        assert numbers(blocked.missing) == pytest.approx([0, AIM - 0.05])
        assert not numbers(blocked.pending)

    def test_what_can_be_restored_is_pending_and_not_missing(self):
        free = restored(clearances([0.5, 0.05]))
        assert numbers(free.missing).tolist() == [0, 0]
        assert numbers(free.pending)
