"""A strategy of one's own: damping that grows near singular poses (Nakamura and Hanafusa 1986)."""

from dataclasses import dataclass, field

import jtik
from jtik.strategy import Backtracking, Composition, Positive, SecondaryTerm, TaskDisplacement, TaskStep
from jtik.symbolic import fmax, sqrt
from jtik.symbolic.factorization import damped_multipliers
from jtik.symbolic.svd import SingularValues
from jtik_formulations import ProjectedGradient


@dataclass(frozen=True, kw_only=True)
class NearSingularStep(TaskStep):
    threshold: float
    largest: float

    def initial_state(self, shape):
        return Backtracking().initial_state()

    def propose(self, model, state):
        J, r = model.J_free, model.here.residual
        smallest = sqrt(SingularValues(J).squared[-1] + 1e-16)
        damping = self.largest * fmax(1 - smallest / self.threshold, 0) ** 2
        dq = -J.T @ damped_multipliers(J, damping, r)  # added to q
        return TaskDisplacement(Backtracking().fraction(state) * dq)

    def adapt(self, model, state, task, outcome):
        return Backtracking().adapt(state, outcome)


@dataclass(frozen=True, kw_only=True)
class NearSingular(Composition):
    threshold: Positive = 0.1
    largest: Positive = 0.01
    secondary: SecondaryTerm = field(default_factory=ProjectedGradient)

    def task_step(self):
        return NearSingularStep(threshold=self.threshold, largest=self.largest)

    def secondary_term(self):
        return self.secondary

    def acceptance(self):
        return "merit"


arm = jtik.Robot.planar(4)
ik = jtik.InverseKinematics(arm, jtik.FrameTask("tip", kind="position"), strategy=NearSingular(threshold=0.2))
print(ik.solve([3.0, 1.5], q0=[0.3, 0.2, -0.1, 0.2]))
