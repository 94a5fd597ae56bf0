"""Spatial arms at and near singular postures, and on a closed path."""

from __future__ import annotations

import math

import numpy as np

from jtik.problems.case import Case, ProblemSet
from jtik.problems.collection.named_problem import NamedProblem
from jtik.robot import Robot
from jtik.task import FrameTask

ELBOW, SHOULDER_LINK, WRIST_LINK = 0.0825, 0.316, 0.384
"""Panda: offset of the elbow, distance from shoulder to elbow, and distance from elbow to wrist [m]."""


def panda_stretched() -> NamedProblem:
    """A stretched Panda: shoulder, elbow axis and wrist on one line, and the first wrist axis orthogonal to it.

    With joint 4 at -atan(a / d3) - atan(a / d5), the distance from shoulder to wrist is largest. With joint 5 at zero,
    the offset of the last joints does not restore the lost direction.
    """
    robot, task = Robot.builtin("panda"), FrameTask("tip", kind="pose")
    origin = (
        "a stretched Panda: joint 4 with shoulder, elbow and wrist on a line, joint 5 at zero; the target is inside"
    )
    stretched = -math.atan2(ELBOW, SHOULDER_LINK) - math.atan2(ELBOW, WRIST_LINK)
    cases = []
    for i, others in enumerate(((0.3, 0.5, 0.4, 1.6, 0.5), (0.3, -0.4, -0.9, 2.6, 0.5), (0.0, 0.6, 0.0, 1.8, 0.8))):
        posture = np.array([*others[:3], stretched, 0.0, *others[3:]])
        goal = posture + np.array([0.0, -0.4, 0.0, -0.9, 0.2, 0.5, 0.0])
        for offset in (0.0, 1e-6, 1e-3):
            cases.append(
                Case(
                    name=f"panda_stretched {i} {offset:g}",
                    kind="near_singular",
                    q0=posture - offset * np.array([0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0]),
                    targets=(robot.pose(goal),),
                    reachable=True,
                    known={"error": 0.0} | ({"sigma_min": 0.0} if offset == 0 else {}),
                    origin=origin,
                )
            )
    return NamedProblem(
        name="panda_stretched",
        summary="a stretched Panda with its target inside, from a singular posture and 1e-6 and 1e-3 rad beside it",
        robot=robot,
        task=task,
        problems=ProblemSet("panda_stretched", tuple(cases), origin=origin),
        origin=origin,
    )


def ur5e_wrist() -> NamedProblem:
    """A UR5e at its wrist singularity: the axes of wrist 1 and wrist 3 are parallel if wrist 2 is zero.

    The shoulder lift, the elbow, wrist 1 and wrist 3 then have four parallel axes, which span only three motions.
    """
    robot, task = Robot.builtin("ur5e"), FrameTask("tip", kind="pose")
    origin = "the wrist singularity of a UR5e, wrist 2 at zero; the target is the pose with wrist 2 at 0.3 rad"
    cases = []
    for offset in (0.0, 1e-6, 1e-3):
        q0 = robot.keyframes["home"].copy()
        goal = q0 + np.array([0.1, -0.1, 0.2, 0.1, 0.0, 0.2])
        q0[4], goal[4] = offset, 0.3
        cases.append(
            Case(
                name=f"ur5e_wrist {offset:g}",
                kind="near_singular",
                q0=q0,
                targets=(robot.pose(goal),),
                reachable=True,
                known={"error": 0.0} | ({"sigma_min": 0.0} if offset == 0 else {}),
                origin=origin,
            )
        )
    return NamedProblem(
        name="ur5e_wrist",
        summary="a target away from the wrist singularity, from the singularity and from 1e-6 and 1e-3 rad beside it",
        robot=robot,
        task=task,
        problems=ProblemSet("ur5e_wrist", tuple(cases), origin=origin),
        origin=origin,
    )


def circle_panda() -> NamedProblem:
    """A circle of a Panda's hand in the y-z plane with constant orientation."""
    robot, task = Robot.builtin("panda"), FrameTask("tip", kind="pose")
    origin = "from the Panda's home posture, in the y-z plane of the base, with constant hand orientation"
    q0 = robot.keyframes["home"]
    cases = []
    for radius in (0.05, 0.1):
        targets = np.repeat(robot.pose(q0)[None], 101, axis=0)
        angle = np.linspace(0, 2 * np.pi, 101)
        targets[:, 1, 3] += radius * np.sin(angle)
        targets[:, 2, 3] += radius * (1 - np.cos(angle))
        targets[-1] = targets[0]
        cases.append(
            Case(
                name=f"circle_panda r={radius:g}",
                kind="circle",
                q0=q0,
                targets=tuple(targets),
                dt=0.02,
                closed=True,
                reachable=True,
                known={"error": 0.0, "size": radius},
                origin=origin,
            )
        )
    return NamedProblem(
        name="circle_panda",
        summary="a circle of the hand in a vertical plane that passes through the start",
        robot=robot,
        task=task,
        problems=ProblemSet("circle_panda", tuple(cases), origin=origin),
        origin=origin,
    )
