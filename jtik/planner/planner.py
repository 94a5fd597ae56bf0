"""The interactive planner: an operator guides the end effector through an obstacle field."""

from __future__ import annotations

import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from jtik.constraints import Limits
from jtik.demo.scene import Scene as Demo
from jtik.geometry import Scene, Slots
from jtik.planner.catalogue import Criteria
from jtik.planner.loop import Loop
from jtik.planner.settings import Problem, Structure, Values
from jtik.planner.solving import Solver, Workshop
from jtik.planner.state import Messages, State
from jtik.task import FrameTask


def ten_links(clock=time.monotonic, executor=None) -> Loop:
    demo = Demo()
    scene = Scene()
    for i, o in enumerate(demo.obstacles):
        scene = scene.with_(f"disc {i + 1}", o)
    problem = Problem(robot=demo.robot, task=FrameTask("tip"), criteria=Criteria(), limits=Limits(velocity=2.0))
    structure = Structure(
        "hybrid", {}, ("joint_centering", "obstacle_avoidance"), True, False, Slots.of(scene, None, 2)
    )
    solver = Solver(problem, structure)
    workshop = Workshop(problem, executor or ThreadPoolExecutor(1))
    workshop.keep(solver)
    values = Values(scene, np.zeros(10), {}, 0.05)
    state = State(problem, solver, values, np.array(demo.start), target_speed=(1.5, 1.5), messages=Messages(clock))
    return Loop(state, workshop, clock=clock)
