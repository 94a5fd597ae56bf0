"""Problems, and their inputs as numbers, that the tests of the step share."""

from __future__ import annotations

import casadi
import numpy as np

import jtik
from jtik._step.inputs import Inputs, Settings
from jtik._step.symbolic_problem import SymbolicProblem
from jtik.constraints.limits import Limits
from jtik.criterion import CriterionTerms
from jtik.task import TaskStack


def problem_of(robot, tasks=None, *, criteria=None, clearances=()):
    """The problem of a robot with position limits only; the task is the position of the tip by default."""
    stack = TaskStack.of(robot, tasks or jtik.FrameTask())
    terms = CriterionTerms.of(robot, criteria, clearances)
    return SymbolicProblem(robot, stack, terms, Limits(velocity=False).of(robot).bounded, tuple(clearances))


def inputs_of(problem, target, **settings):
    """The inputs of a step as arrays."""
    robot = problem.robot
    numbers = problem.tasks.read_target(target), problem.terms.parameters.memory, robot.lower, robot.upper
    return Inputs(*numbers, np.array(Settings(**settings), dtype=float))


def numbers(expression):
    """The value of a constant expression: a number, or an array (n,) or (m, n)."""
    value = np.array(casadi.DM(casadi.SX(expression)))
    return value.item() if value.size == 1 else value[:, 0] if value.shape[1] == 1 else value


def constants(inputs):
    """Inputs as constant expressions."""
    return Inputs(*map(casadi.SX, inputs))
