"""What takes long: solve an attempt again, save, load and recover a plan, each in another thread."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import Executor, Future
from dataclasses import replace
from pathlib import Path
from typing import Any

from jtik.arguments import instance
from jtik.errors import ArgumentError, JtikError, UnknownNameError
from jtik.geometry import Scene
from jtik.planner.attempts.attempt import Attempt
from jtik.planner.attempts.of_session import Attempts
from jtik.planner.attempts.resolving import resolved
from jtik.planner.edits import of_attempts as edits
from jtik.planner.edits.effects import Editor
from jtik.planner.edits.messages import Edit
from jtik.planner.files.plan_file import Plan
from jtik.planner.files.plan_settings import from_plain, to_plain
from jtik.planner.files.recovery import Recovered, recover
from jtik.planner.files.sessions import Session
from jtik.planner.session.state import State
from jtik.planner.session.targets import of_settings
from jtik.robot import Robot


class Background:
    """Jobs in other threads, whose results the loop takes.

    Args:
        state: the state.
        attempts: the attempts.
        editor: takes settings and obstacles.
        executor: where the jobs run.
        sessions: former sessions that can be recovered.

    Attributes:
        sessions: former sessions that can be recovered.
    """

    def __init__(
        self, state: State, attempts: Attempts, editor: Editor, executor: Executor, sessions: tuple[Session, ...] = ()
    ) -> None:
        self._state, self._attempts, self._editor, self._executor = state, attempts, editor, executor
        self.sessions = sessions
        self._jobs: list[tuple[str, Future[Any], Callable[[Any], None]]] = []
        self._handlers: Mapping[type[Edit], Callable[[Any], None]] = {
            edits.Resolve: self._resolve,
            edits.SavePlan: self._save,
            edits.LoadPlan: self._load,
            edits.Recover: self._recover,
            edits.TakePlan: self._take_given,
        }

    @property
    def busy(self) -> bool:
        """Whether a job runs."""
        return bool(self._jobs)

    def handles(self, edit: Edit) -> bool:
        """Whether an edit is one of these."""
        return type(edit) in self._handlers

    def apply(self, edit: Edit) -> None:
        """Begin a job. Raises JtikError for one that cannot begin."""
        self._handlers[type(edit)](edit)

    def poll(self) -> None:
        """Take the results of the jobs that have ended; errors are reported."""
        jobs, self._jobs = self._jobs, []
        for name, future, done in jobs:
            if not future.done():
                self._jobs.append((name, future, done))
                continue
            try:
                done(future.result())
            except Exception as problem:  # what a disk, or a criterion of a third party, may raise
                reason = str(problem) if isinstance(problem, JtikError) else f"{type(problem).__name__}: {problem}"
                self._state.messages.tell("error", f"{name}: {reason}")

    def _begin(self, name: str, done: Callable[[Any], None], work: Callable[..., Any], *arguments: Any) -> None:
        self._jobs.append((name, self._executor.submit(work, *arguments), done))

    def _resolve(self, edit: edits.Resolve) -> None:
        attempt, state = self._attempts.history[edit.attempt], self._state
        changes: dict[str, Any] = {} if edit.criteria is None else {"criteria": edit.criteria}
        if edit.strategy is not None:
            changes |= {"strategy": edit.strategy, "options": dict(edit.options or {})}
        structure = self._editor.checked(**changes)
        settings = {**to_plain(state), "criteria": list(structure.criteria)}
        settings["strategy"] = {"name": structure.strategy, "options": dict(structure.options)}

        def done(found: Attempt) -> None:
            name = self._attempts.history.free_name(edit.attempt) if edit.name is None else edit.name
            self._attempts.add(replace(found, name=name))
            state.messages.tell("info", f"{edit.attempt!r} is solved again as {name!r}")

        targets = of_settings(attempt.settings, state.problem, state.targets)
        if "targets" in attempt.settings:
            settings["targets"] = attempt.settings["targets"]
        what = (state.problem, structure, state.values, attempt, settings, targets)
        self._begin(f"resolve {edit.attempt!r}", done, resolved, *what)

    def _save(self, edit: edits.SavePlan) -> None:
        def done(_: None) -> None:
            self._state.messages.tell("info", f"the plan is saved: {edit.path}")

        self._begin("save_plan", done, self._attempts.plan().save, edit.path)

    def _load(self, edit: edits.LoadPlan) -> None:
        def done(plan: Plan) -> None:
            self._take(plan)
            self._state.messages.tell("info", f"the plan is loaded: {edit.path}")

        self._begin("load_plan", done, Plan.load, edit.path, self._state.arm.robot)

    def _recover(self, edit: edits.Recover) -> None:
        folders = {session.folder.name: session.folder for session in self.sessions}
        if edit.session not in folders:
            raise UnknownNameError("session", edit.session, folders)

        def done(found: Recovered) -> None:
            self._take(found.plan)
            for note in found.notes:
                self._state.messages.tell("warning", note)
            self._state.messages.tell("info", f"the session {edit.session} is recovered")

        self._begin("recover", done, recovered, folders[edit.session], self._state.arm.robot)

    def _take_given(self, edit: edits.TakePlan) -> None:
        self._take(instance("plan", edit.plan, Plan, "a Plan"))
        self._state.messages.tell("info", "the plan is loaded")

    def _take(self, plan: Plan) -> None:
        """Take a plan in place of the present one."""
        settings = from_plain(plan.settings, self._state.arm.robot)
        scene = Scene.from_dict(plan.scene) if plan.scene else Scene()
        self._editor.restore(settings, scene)
        self._attempts.replace_history(plan.history)


def recovered(folder: Path, robot: Robot) -> Recovered:
    """What a session has left. Raises ArgumentError where it is of another robot."""
    found = recover(folder)
    joints = list(found.plan.robot["joint_names"])
    if joints != list(robot.joint_names):
        given = f"{folder.name}, of {found.plan.robot['name']!r} with the joints {', '.join(joints)}"
        raise ArgumentError("session", given, f"a session with {robot.name!r}: {', '.join(robot.joint_names)}")
    return found
