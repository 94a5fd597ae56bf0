"""Attempts of a session: recorded, shown, undone, branched and chosen."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from jtik.errors import ArgumentError
from jtik.geometry import Scene
from jtik.planner.attempts.attempt import Attempt
from jtik.planner.attempts.history import History
from jtik.planner.attempts.recording import Recording
from jtik.planner.edits import of_attempts as edits
from jtik.planner.edits.effects import Editor
from jtik.planner.edits.messages import Edit, Guide, Jog
from jtik.planner.files.journal import Journal
from jtik.planner.files.plan_file import Plan
from jtik.planner.files.plan_settings import to_plain
from jtik.planner.session.frames import Mode
from jtik.planner.session.state import Motion, State
from jtik.planner.session.targets import Targets, of_settings
from jtik.types import Array


class Attempts:
    """What the edits of attempts do.

    Args:
        state: the state.
        editor: changes the obstacles.
        dt: period [s].
        journal: where what is recorded is kept; None for nowhere.

    Attributes:
        history: the attempts.
        mode: whether the arm follows the target, or an attempt is shown.
        version: grows with every change of the attempts.
    """

    def __init__(self, state: State, editor: Editor, *, dt: float, journal: Journal | None = None) -> None:
        self._state, self._editor, self._dt, self._journal = state, editor, dt, journal
        self.history = History()
        self.mode: Mode = "live"
        self.version = 0
        self._shown: tuple[Attempt, float] | None = None
        self._shown_targets = state.targets
        self._speed, self._time = 1.0, 0.0
        self._recording: Recording | None = None
        self._recorded_scene: Scene | None = None
        self._handlers: Mapping[type[Edit], Callable[[Any], None]] = {
            Guide: self._guide,
            edits.Record: self._record,
            edits.StopRecording: self._stop_recording,
            edits.Play: self._play,
            edits.Pause: self._pause,
            edits.Live: lambda edit: self._live(),
            edits.Scrub: self._scrub,
            edits.Undo: self._undo,
            edits.Branch: self._branch,
            edits.Choose: lambda edit: self._change(self.history.choose(edit.attempt)),
            edits.DeleteAttempt: self._delete,
            edits.RenameAttempt: self._rename,
        }

    @property
    def recording(self) -> bool:
        """Whether an attempt is recorded."""
        return self._recording is not None

    def handles(self, edit: Edit) -> bool:
        """Whether an edit is one of these."""
        return type(edit) in self._handlers

    def apply(self, edit: Edit) -> None:
        """Apply an edit. Raises JtikError for one that cannot be applied."""
        self._handlers[type(edit)](edit)
        if self._journal is not None and isinstance(edit, (edits.Choose, edits.DeleteAttempt, edits.RenameAttempt)):
            self._journal.edit(self._time, edit.to_json())
            self.snapshot()

    @property
    def shown(self) -> tuple[str, float] | None:
        """Name and time [s] of the attempt that is shown."""
        return None if self._shown is None else (self._shown[0].name, self._shown[1])

    def sample(self) -> tuple[Array, Array, Array | None]:
        """Configuration, position and orientation of the target of what is shown."""
        attempt, time = self._present()
        i = attempt.index(time)
        q, target = attempt.configurations[i], attempt.targets[i]
        dimension = self._state.arm.robot.dimension
        return q, target[:dimension], target[3:] if len(target) == 7 else None

    @property
    def targets(self) -> Targets:
        """The targets of what is shown; the present ones where nothing is shown."""
        return self._state.targets if self._shown is None else self._shown_targets

    def scene(self) -> dict[str, Any] | None:
        """The obstacles of what is shown, a dict of `jtik.Scene.to_dict`; None where nothing is shown."""
        return None if self._shown is None else self._shown[0].scene_at(self._shown[1]) or Scene().to_dict()

    def advance(self) -> bool:
        """One period of what is played; whether what is shown has moved."""
        if self.mode != "playing":
            return False
        attempt, time = self._present()
        later = time + self._dt * self._speed
        if later >= attempt.duration:
            later, self.mode = attempt.duration, "paused"
        self._shown = attempt, later
        return True

    def note(self, time: float) -> None:
        """Add a sample to the recording, where there is one; called once a period.

        Args:
            time: number of periods times their length [s].
        """
        self._time = time
        if self._recording is None:
            return
        state = self._state
        if state.values.scene is not self._recorded_scene:
            self._recorded_scene = state.values.scene
            data = state.values.scene.to_dict()
            self._recording.change_scene(data)
            if self._journal is not None:
                self._journal.scene(data)
        self._recording.add(time, state.q, self._target())
        if self._journal is not None:
            self._journal.sample(time, state.q, self._target())

    def plan(self) -> Plan:
        """The whole plan as it is."""
        state = self._state
        return Plan(
            robot=Plan.robot_of(state.arm.robot),
            scene=state.values.scene.to_dict(),
            settings=to_plain(state),
            history=self.history,
        )

    def replace_history(self, history: History) -> None:
        """Take other attempts, those of a plan that was loaded."""
        self.stop()
        self._live()
        self._change(history)
        self.snapshot()

    def add(self, attempt: Attempt) -> None:
        """Add an attempt. Raises ArgumentError for a name that is taken, or a parent that is gone."""
        self._change(self.history.add(attempt))
        self.snapshot()

    def snapshot(self) -> None:
        """Have the journal keep the plan as it is."""
        if self._journal is not None:
            self._journal.snapshot(self.plan())

    def stop(self) -> None:
        """End the recording, where there is one, and keep it."""
        if self._recording is not None:
            self._end(keep=True)

    def _target(self) -> Array:
        target = self._state.target
        if not target.turns:
            return target.position
        position = np.zeros(3)
        position[: len(target.position)] = target.position
        return np.concatenate([position, target.orientation])

    def _present(self) -> tuple[Attempt, float]:
        if self._shown is None:
            raise ArgumentError("attempt", "none that is shown", "play or scrub one first")
        return self._shown

    def _guide(self, edit: Guide) -> None:
        if self._recording is not None:
            raise ArgumentError("guide", "while an attempt is recorded", "stop that recording first")
        self._state.guide(edit.task)

    def _settings(self) -> dict[str, Any]:
        """The settings of an attempt that begins; with several tasks also their targets."""
        state = self._state
        targets = {"targets": state.targets.to_plain(state.problem)} if len(state.problem.tasks) > 1 else {}
        return {**to_plain(state), **targets}

    def _targets_of(self, attempt: Attempt) -> Targets:
        return of_settings(attempt.settings, self._state.problem, self._state.targets)

    def _record(self, edit: edits.Record) -> None:
        if self._recording is not None:
            raise ArgumentError("record", "while an attempt is recorded", "stop that recording first")
        name = self.history.free_name() if edit.name is None else edit.name
        if name in self.history:
            raise ArgumentError("name", name, "a name that no other attempt has")
        self._live()
        state, target = self._state, self._target()
        beginning = Attempt(
            name=name,
            dt=self._dt,
            times=np.zeros(1),
            configurations=state.q[None],
            targets=target[None],
            scenes=((0.0, state.values.scene.to_dict()),),
            strategy=state.wanted.strategy,
            criteria=state.wanted.criteria,
            settings=self._settings(),
        )
        self._begin(beginning)

    def _begin(self, beginning: Attempt) -> None:
        self._recording, self._recorded_scene = Recording(beginning), self._state.values.scene
        if self._journal is not None:
            self._journal.begin(beginning)

    def _stop_recording(self, edit: edits.StopRecording) -> None:
        if self._recording is None:
            raise ArgumentError("stop_recording", "while nothing is recorded", "record an attempt first")
        self._end(keep=edit.keep)

    def _end(self, *, keep: bool) -> None:
        recording, self._recording = self._recording, None
        if keep and recording is not None:
            self._change(self.history.add(recording.attempt()))
        if self._journal is not None:
            self._journal.end(kept=keep)
        self.snapshot()

    def _show(self, name: str, time: float, mode: Mode) -> None:
        attempt = self.history[name]
        self._shown_targets = self._targets_of(attempt)
        self.stop()
        self._state.target.stop()
        self._state.jog = Jog(0.0)
        self._shown, self.mode = (attempt, min(time, attempt.duration)), mode

    def _play(self, edit: edits.Play) -> None:
        goes_on = self._shown is not None and self._shown[0].name == edit.attempt
        time = self._shown[1] if self._shown is not None and goes_on else 0.0
        if goes_on and time >= self.history[edit.attempt].duration:
            time = 0.0
        self._show(edit.attempt, time, "playing")
        self._speed = edit.speed

    def _pause(self, edit: edits.Pause) -> None:
        if self._shown is not None:
            self.mode = "paused"

    def _scrub(self, edit: edits.Scrub) -> None:
        self._show(edit.attempt, edit.time, "scrubbing")

    def _live(self) -> None:
        self._shown, self.mode = None, "live"

    def _undo(self, edit: edits.Undo) -> None:
        self._go_back(edit, moving=False)

    def _go_back(self, edit: edits.Undo | edits.Branch, *, moving: bool) -> None:
        """Put the arm and the obstacles where they were in an attempt, at rest or as fast as the arm was."""
        self.stop()
        attempt = self.history.branch(edit.attempt, edit.time)
        self._show(edit.attempt, edit.time, "scrubbing")
        q, position, orientation = self.sample()
        scene = attempt.scene_at(edit.time)
        self._live()
        i = attempt.index(edit.time)
        motion = None
        if moving and i > 0:
            motion = Motion(attempt.configurations[i - 1], q, float(attempt.times[i] - attempt.times[i - 1]))
        self._state.take_targets(self._targets_of(attempt))
        self._state.put(q, position, orientation, motion=motion)
        if scene is not None:
            self._editor.change_scene(Scene.from_dict(scene))

    def _branch(self, edit: edits.Branch) -> None:
        self.stop()
        beginning = self.history.branch(edit.attempt, edit.time, new_name=edit.name)
        if beginning.name in self.history:
            raise ArgumentError("name", beginning.name, "a name that no other attempt has")
        self._go_back(edit, moving=True)  # so that the branch goes on without a jump of its velocities
        state = self._state
        wanted, settings = state.wanted, self._settings()
        self._begin(replace(beginning, strategy=wanted.strategy, criteria=wanted.criteria, settings=settings))

    def _change(self, history: History) -> None:
        self.history = history
        self.version += 1

    def _delete(self, edit: edits.DeleteAttempt) -> None:
        history = self.history.delete(edit.attempt)
        if self._shown is not None and self._shown[0].name == edit.attempt:
            self._live()
        self._change(history)

    def _rename(self, edit: edits.RenameAttempt) -> None:
        self._change(self.history.rename(edit.attempt, edit.name))
        if self._shown is not None and self._shown[0].name == edit.attempt:
            self._shown = self.history[edit.name], self._shown[1]
