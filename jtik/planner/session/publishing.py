"""The setup and the settings of a session as they are published."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from jtik.planner.session import catalogue
from jtik.planner.session.frames import Settings, Setup
from jtik.planner.session.solving import GIVEN
from jtik.planner.session.state import State


def setup_of(state: State, dt: float) -> Setup:
    """What a session plans for.

    Args:
        state: its state.
        dt: period [s].
    """
    problem = state.problem
    strategies = catalogue.strategy_entries()
    if problem.strategy is not None:
        given = {"name": GIVEN, "summary": repr(problem.strategy), "options": ()}
        strategies = (given, *strategies)
    return Setup(
        robot=state.arm.description(),
        frames=problem.robot.frame_names,
        strategies=strategies,
        criteria=problem.criteria.entries(),
        task={"kind": problem.tasks[0].kind, "frame": state.arm.tip},
        dt=dt,
    )


def settings_of(state: State, shown: Mapping[str, Any] | None, *, rebuilding: bool) -> Settings:
    """What a session is set to.

    Args:
        state: its state.
        shown: the obstacles of an attempt that is shown; None for the present ones.
        rebuilding: whether another solver is being built.
    """
    wanted, values = state.wanted, state.values
    scene = values.scene.to_dict() if shown is None else shown
    return Settings(
        version=state.changes,
        tasks=tuple(
            {
                "name": task.name,
                "kind": task.kind,
                "frame": state.problem.guided_frame(task.name),
                "held": None if task.name not in state.targets.held else state.targets.held[task.name].position,
            }
            for task in state.problem.tasks
        ),
        strategy={"name": wanted.strategy, "options": dict(wanted.options)},
        criteria=wanted.criteria,
        joint_weights=wanted.joint_weights,
        scene=scene["obstacles"],
        preferred=tuple(values.preferred.tolist()),
        gains={name: value.tolist() for name, value in state.solver.gains.items()},
        limits=wanted.limits,
        clearance=wanted.clearance,
        safe=values.safe,
        target_speed=(state.target.speed, state.target.rotation_speed),
        capacity=dict(state.solver.structure.slots.counts),
        rebuilding=rebuilding,
    )
