"""Edits of the target, the obstacles and the settings: what each does to the state."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from jtik.errors import ArgumentError, JtikError, UnknownNameError
from jtik.geometry import Scene, Solid
from jtik.geometry.scene_data import obstacle_from
from jtik.geometry.slots import read_obstacles
from jtik.planner.edits import messages as edits
from jtik.planner.files.plan_settings import Restored
from jtik.planner.session import catalogue, slots
from jtik.planner.session.settings import Structure, joint_weights
from jtik.planner.session.solving import GIVEN, Solver, Workshop
from jtik.planner.session.state import State
from jtik.robot import JointType

SCALAR = (JointType.REVOLUTE, JointType.PRISMATIC)


class Editor:
    """Applies edits to the state, and asks for a solver where one has to be built.

    Args:
        state: the state.
        workshop: builds solvers.
    """

    def __init__(self, state: State, workshop: Workshop) -> None:
        self._state, self._workshop = state, workshop
        self._handlers: Mapping[type[edits.Edit], Callable[[Any], None]] = {
            edits.MoveTarget: self._move_target,
            edits.HoldTarget: self._hold_target,
            edits.SetTargetSpeed: self._set_target_speed,
            edits.AddObstacle: self._add_obstacle,
            edits.ChangeObstacle: self._change_obstacle,
            edits.DeleteObstacle: self._delete_obstacle,
            edits.SetObstacleGain: self._set_obstacle_gain,
            edits.SetPreferred: self._set_preferred,
            edits.TakePosture: self._take_posture,
            edits.SetJointWeights: self._set_joint_weights,
            edits.SetGain: self._set_gain,
            edits.SetStrategy: self._set_strategy,
            edits.SetCriteria: self._set_criteria,
            edits.SetLimits: self._set_limits,
            edits.SetClearance: self._set_clearance,
            edits.Jog: self._jog,
        }

    def handles(self, edit: edits.Edit) -> bool:
        """Whether an edit is one of these."""
        return type(edit) in self._handlers

    def apply(self, edit: edits.Edit) -> None:
        """Apply an edit. Raises JtikError for one that cannot be applied; the state is then as before."""
        self._handlers[type(edit)](edit)

    def swap(self) -> None:
        """Take a solver that is ready, or report why there is none and go on with the present one."""
        ready = self._workshop.poll()
        if ready is None:
            return
        state, found = self._state, ready
        if isinstance(found, Solver):
            state.take(found)
            return
        reason = str(found) if isinstance(found, JtikError) else f"{type(found).__name__}: {found}"
        state.messages.tell("error", f"the solver could not be built, the one before goes on: {reason}")
        state.wanted = state.solver.structure
        scene = slots.part(state.wanted.slots, state.values.scene)
        lost = [name for name in state.values.scene.names if name not in scene]
        if lost:
            state.messages.tell("error", f"without a place, and left out: {', '.join(lost)}")
            state.set_scene(scene)
        state.touch()

    def change_scene(self, scene: Scene) -> None:
        """Take another scene; where it does not fit the present solver, ask for one with more places."""
        self._state.set_scene(scene)
        places = self._state.wanted.slots
        if not slots.has_room(places, scene):
            self._request(slots=slots.grown(places, scene))

    def checked(self, **changes: Any) -> Structure:
        """The structure that was asked for last, with changes. What is wrong with them is found at once.

        Raises:
            JtikError: for a strategy, an option or a criterion that does not exist, or weights that cannot be used.
        """
        if "joint_weights" in changes:
            changes["joint_weights"] = joint_weights(self._state.problem.robot, changes["joint_weights"])
        wanted: Structure = replace(self._state.wanted, **changes)
        if wanted.strategy != GIVEN or self._state.problem.strategy is None:
            catalogue.strategy(wanted.strategy, wanted.options)
        known = self._state.problem.criteria.names() if "criteria" in changes else ()
        for name in wanted.criteria if known else ():
            if name not in known:
                raise UnknownNameError("criterion", name, known)
        return wanted

    def restore(self, settings: Restored, scene: Scene) -> None:
        """Take the settings and the obstacles of a plan that was loaded.

        Raises:
            JtikError: for a strategy or a criterion that does not exist; nothing is then changed.
        """
        state = self._state
        switches = {"limits": settings.limits, "clearance": settings.clearance}
        changes: dict[str, Any] = {name: on for name, on in switches.items() if on is not None}
        if settings.strategy is not None:
            changes |= {"strategy": settings.strategy.name, "options": dict(settings.strategy.options)}
        if settings.criteria is not None:
            changes["criteria"] = settings.criteria.names
        if settings.joint_weights is not None:
            changes["joint_weights"] = settings.joint_weights
        self.checked(**changes)
        read_obstacles(scene, state.arm.robot.dimension)
        values = {"preferred": settings.preferred, "gains": settings.gains, "safe": settings.safe}
        state.set_values(**{name: value for name, value in values.items() if value is not None})
        if settings.target_speed is not None:
            self._set_target_speed(settings.target_speed)
        self.change_scene(scene)
        self._request(**changes)

    def _move_target(self, edit: edits.MoveTarget) -> None:
        self._check_size("position", edit.position)
        self._state.target.move(edit)

    def _hold_target(self, edit: edits.HoldTarget) -> None:
        self._check_size("velocity", edit.velocity)
        self._state.target.hold(edit)

    def _check_size(self, argument: str, numbers: tuple[float, ...]) -> None:
        dimension = self._state.arm.robot.dimension
        if len(numbers) != dimension:
            raise ArgumentError(argument, numbers, f"{dimension} numbers for this robot")

    def _set_target_speed(self, edit: edits.SetTargetSpeed) -> None:
        rotation = self._state.target.rotation_speed if edit.rotation is None else edit.rotation
        self._state.set_target_speed(edit.speed, rotation)

    def _add_obstacle(self, edit: edits.AddObstacle) -> None:
        scene = self._state.values.scene
        if edit.name in scene:
            raise ArgumentError("name", edit.name, "a name that no other obstacle has")
        self.change_scene(scene.with_(edit.name, self._obstacle(edit.obstacle), edit.gain))

    def _change_obstacle(self, edit: edits.ChangeObstacle) -> None:
        scene = self._named(edit.name)
        self.change_scene(scene.with_(edit.name, self._obstacle(edit.obstacle), scene.gains[edit.name]))

    def _delete_obstacle(self, edit: edits.DeleteObstacle) -> None:
        self.change_scene(self._named(edit.name).without(edit.name))

    def _set_obstacle_gain(self, edit: edits.SetObstacleGain) -> None:
        scene = self._named(edit.name)
        self.change_scene(scene.with_(edit.name, scene[edit.name], edit.gain))

    def _named(self, name: str) -> Scene:
        """The scene. Raises UnknownNameError where no obstacle has the name."""
        scene = self._state.values.scene
        scene[name]
        return scene

    def _obstacle(self, data: Mapping[str, Any]) -> Solid:
        """The obstacle of plain data. Raises ArgumentError for other data, or one of another dimension."""
        obstacle, _ = obstacle_from("obstacle", data)
        return read_obstacles(obstacle, self._state.arm.robot.dimension)[0]

    def _set_preferred(self, edit: edits.SetPreferred) -> None:
        robot = self._state.arm.robot
        scalar = [joint.name for joint in robot.independent_joints if joint.type in SCALAR]
        if edit.joint not in scalar:
            raise UnknownNameError("revolute or prismatic joint", edit.joint, scalar)
        preferred = self._state.values.preferred.copy()
        preferred[robot.q_slice(edit.joint)] = edit.value
        self._state.set_values(preferred=preferred)

    def _take_posture(self, edit: edits.TakePosture) -> None:
        self._state.set_values(preferred=self._state.q.copy())

    def _set_joint_weights(self, edit: edits.SetJointWeights) -> None:
        robot, weights = self._state.arm.robot, self._state.wanted.joint_weights
        self._request(joint_weights=robot.velocity_values(dict(edit.weights), default=weights, argument="weights"))

    def _set_gain(self, edit: edits.SetGain) -> None:
        self._state.solver.set_gain(edit.parameter, np.array(edit.value))
        self._state.set_values(gains={**self._state.values.gains, edit.parameter: edit.value})

    def _set_strategy(self, edit: edits.SetStrategy) -> None:
        self._request(strategy=edit.name, options=dict(edit.options))

    def _set_criteria(self, edit: edits.SetCriteria) -> None:
        self._request(criteria=edit.names)

    def _set_limits(self, edit: edits.SetLimits) -> None:
        self._request(limits=edit.on)

    def _set_clearance(self, edit: edits.SetClearance) -> None:
        if edit.safe is not None:
            self._state.set_values(safe=edit.safe)
        self._request(clearance=edit.on)

    def _jog(self, edit: edits.Jog) -> None:
        state = self._state
        if edit.rate != 0:  # what is wrong with the direction is found at once
            state.solver.ik.jog(state.q, 0.0, direction=edit.direction)
        state.jog = edit

    def _request(self, **changes: Any) -> None:
        """Ask for a solver of another structure, unless the present one is of that structure."""
        state, wanted = self._state, self.checked(**changes)
        if wanted.key != state.wanted.key:
            state.wanted = wanted
            self._workshop.request(wanted)
            state.touch()
