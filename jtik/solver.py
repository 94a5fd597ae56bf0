"""InverseKinematics: a robot, its tasks, its criteria and a strategy, compiled once; then step, solve and track."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from jtik._loop.control_loop import ControlLoop
from jtik._loop.copying import FixedSolver
from jtik._loop.engine import Engine
from jtik._loop.locked_joints import LockedJoints
from jtik._loop.options import Compiled, Until, read_executor
from jtik.arguments import flag, positive_integer
from jtik.constraints.clearance import Clearance, clearances_of
from jtik.constraints.limits import Limits, limits_of
from jtik.constructors import Constructed
from jtik.criterion import Criteria, CriterionSum, Parameters
from jtik.progress import Progress, counted
from jtik.qp import Backend
from jtik.registry import strategy_of
from jtik.result import Solution, SolutionBatch, Step, Trajectory
from jtik.robot import Robot
from jtik.robot.joint_weights import Weights, read_weights
from jtik.strategy import Strategy
from jtik.symbolic.compilation.several_files import Compilation
from jtik.task import Task
from jtik.task.reduction import joints_of

if TYPE_CHECKING:
    from concurrent.futures import Executor

    import qpsolvers


class InverseKinematics(LockedJoints, ControlLoop, FixedSolver, metaclass=Constructed):
    """Joint positions that achieve a task and minimise a criterion with the remaining degrees of freedom.

    Building one compiles the step of `solve`; before a control loop, `warm_up` builds the others. Targets, parameters
    and tolerances are numbers that can change from call to call at no cost. It can be copied and
    pickled, with the parameters as they are. One thread at a time can use it, and no callback of a call of its own: a
    solver that is in use raises JtikError. Make a copy for each thread: ``copy.copy(ik)`` shares the compiled
    functions, and takes a few milliseconds.

    **Configurations.** A ``q`` belongs to `robot`, which has only the joints that move. A ``q`` of the full robot, or
    a dict from joint name to position, is accepted as well.

    **Tolerances** of `solve`, `solve_batch` and `track`; `step` uses their defaults:

    - ``position_tolerance``: norm of the position error that counts as reached [m].
    - ``orientation_tolerance``: norm of the orientation error that counts as reached [rad].
    - ``optimality_tolerance``: norm of (I - J+ J) dH/dv that counts as stationary, relative to max(1, |dH/dv|).
    - ``until``: "stationary" continues until the criterion cannot fall further, and leaves its saddle points and
      maxima; "reached" stops at the target.

    Example:
        >>> arm = jtik.Robot.planar(3)
        >>> ik = jtik.InverseKinematics(arm, jtik.FrameTask("tip", kind="position"), criteria=JointCentering())
        >>> ik.solve([2.0, 1.0], q0=[0.1, 0.2, 0.3]).status.name
        'CONVERGED'

    Args:
        robot: the robot.
        task: a Task, or several, each with a name of its own.
        criteria: what to minimise with the remaining freedom: a criterion, a weighted sum such as ``A - 0.3 * B``, the
            name of a registered criterion, a list of these, or None.
        strategy: name of a registered strategy, perhaps with a secondary term as in "newton+qp", or a Strategy object.
        solver: what solves the quadratic programs of a strategy that has any: a name of `jtik.qp.available`, or a
            `jtik.qp.Backend`; DAQP by default.
        limits: which limits hold, a `Limits`: position limits always, limits of velocity and acceleration in `track`
            and ``step(dt=)``. True for the robot's own positions and velocities; False leaves its position limits out.
        clearances: distances that no accepted step may bring below their safe values, for strategies that support
            them: "weighted_qp", "lexicographic_qp", and task steps with "+qp", such as "hybrid+qp".
        joints: names of the joints to move, or "all"; by default those on which the tasks depend, not a hand's fingers.
        at: configuration of the full robot at which the other joints are locked, its neutral one by default.
        weights: a dict from joint name to a positive number, 1 for the others, or one number for each velocity entry: a
            step minimises the weighted sum of squares of its joint motions, so that heavy joints move less for the
            task. 1 m counts as 1 rad. The posture to which a criterion leads does not depend on the weights.
        null_space_rate: rate at which `track` and ``step(dt=)`` approach the minimum of the criterion [1/s], so that
            their speed in the null space does not depend on dt. Where the strategy has a ``step_limit``, that speed is
            at most about this rate times it. ``math.inf`` for steps as long as those of `solve`.
        compiled: run the step as generated C, three to fifteen times faster. True needs a C compiler and, the first
            time, a second to half a minute; Ctrl-C ends the compiler. "auto" begins on CasADi's virtual machine,
            compiles in a thread once the solver has run for a second, or at `warm_up`, and changes over between two
            calls; results are the same, and without a compiler it goes on as it was. False, or "auto" with the
            environment variable JTIK_COMPILED=off, stays on the virtual machine.
        progress: True for a bar on the terminal while it is built and compiled, or a function called with (done,
            total): the number of parts that are done, and of those known so far; each C file is one.

    Attributes:
        robot: the robot with only the joints that move.
        tasks: the tasks.
        strategy: the strategy.
        limits: the limits that hold.
        parameters: live parameters of criteria and clearances by name:
            ``ik.parameters["joint_centering.weight"] = 2.0``.

    Raises:
        ArgumentError: for an argument that cannot be used, naming it.
        UnknownNameError: for a joint, frame, strategy or solver that does not exist.
        MissingExtraError: for a bar without rich.
    """

    def __init__(
        self,
        robot: Robot,
        task: Task | Iterable[Task],
        *,
        criteria: Criteria = None,
        strategy: str | Strategy = "hybrid",
        solver: str | Backend | None = None,
        limits: bool | Limits = True,
        clearances: Clearance | Iterable[Clearance] | None = None,
        joints: str | Iterable[str] | None = None,
        at: ArrayLike | None = None,
        weights: Weights = None,
        compiled: Compiled = "auto",
        null_space_rate: float = 5.0,
        progress: Progress = False,
    ) -> None:
        self._lock(robot, task, joints := joints_of(joints), at)
        self.limits: Limits = limits_of(limits)
        self.strategy: Strategy = strategy_of(strategy)
        terms: dict[str, Any] = {"criteria": CriterionSum.of(criteria), "clearances": clearances_of(clearances)}
        how: dict[str, Any] = {"solver": solver, "compiled": compiled, "null_space_rate": null_space_rate}
        how["weights"] = read_weights(self.robot, weights)
        with counted(progress, "building") as report, (compilation := Compilation()).shown(report, parts=1):
            built: dict[str, Any] = {**terms, **how, "compilation": compilation}
            self._run_on(Engine(self.robot, self.tasks, self.limits, self.strategy, **built))
        arguments = {"robot": robot, "task": self.tasks.tasks, "limits": self.limits, "strategy": self.strategy}
        self._fix({**arguments, **terms, **how, "joints": joints, "at": self._locked})

    def _run_on(self, engine: Engine) -> None:
        self._engine = engine
        self.parameters: Parameters = engine.problem.terms.parameters
        self._stepping, self._solving = engine.stepping, engine.solving

    def __repr__(self) -> str:
        problem = self._engine.problem
        return f"InverseKinematics({self.robot!r}, {list(self.tasks.tasks)}, {problem.terms}, {self.strategy!r})"

    def solve(
        self,
        target: Any,
        *,
        q0: ArrayLike | None = None,
        restarts: int = 0,
        seed: int | None = None,
        best_of: int = 1,
        jump_limit: float | None = None,
        max_iterations: int = 1000,
        position_tolerance: float = 1e-6,
        orientation_tolerance: float = 1e-6,
        optimality_tolerance: float = 1e-6,
        until: Until = "stationary",
        trace: bool = False,
        lanes: bool = False,
        nearest: bool = False,
    ) -> Solution:
        """Iterate to the target. It always returns a Solution, whose status is why it stopped.

        Args:
            target: what the task accepts, such as (x, y); for several tasks a dict of targets by task name.
            q0: where to start, (nq,); `Robot.home` by default: the keyframe "home" or, without one, the neutral
                configuration off its limits. It is clamped to the limits.
            restarts: how many other starting configurations to try, drawn within the limits, when q0 does not lead to
                the target. Of the first 256 drawn the nearest to the target come first. Each attempt without progress
                then ends early. If none reaches the target, the one with the smallest error is returned.
            seed: seed of the restarts; None is 0. The same seed gives the same solution.
            best_of: go on until so many configurations are found that differ by more than 0.01 rad or m in a joint, or
                all restarts are used. Whole turns make no other configuration, nor does a straight way on target. The
                result is the one with the smallest criterion, or without a criterion the one nearest to q0; the others
                are in ``solution.alternatives``, the best first.
            jump_limit: largest change of any joint from q0 [rad] or [m], mimic joints included; None for none. Of a
                ball or free joint it is that of the angle of its rotation and of the length of its displacement, which
                are judged where an attempt ends. If none ends within the limit, the status says so and q is beyond it.
            max_iterations: most steps to try in an attempt.
            position_tolerance, orientation_tolerance, optimality_tolerance, until: see the class.
            trace: keep every iteration in ``solution.trace``.
            lanes: whether four starts are tried side by side in vector registers, several times faster: q0 and the
                restarts, in the order of their distance from the target, with the steps of ``solve_batch(lanes=True)``.
                The first that arrives, in iterations, is the result, so postures differ from those without lanes, and
                more often from the one that q0 leads to. What they do not reach is left to the search without lanes.
                It needs restarts and compiles C when it is first used.
            nearest: with ``lanes`` the attempt from q0 goes on while its error falls, and where it arrives it is the
                result.

        Raises:
            ArgumentError: for an argument of wrong shape, NaN or infinity, naming it; for ``lanes`` without restarts,
                with best_of, jump_limit or trace, or with a strategy that has none.
            CompilerError: for ``lanes`` without a compiler.
        """
        return self._solving.natives.call(
            target,
            q0,
            lanes,
            nearest,
            trace,
            restarts,
            seed,
            max_iterations,
            best_of,
            jump_limit,
            position_tolerance,
            orientation_tolerance,
            optimality_tolerance,
            until,
        )

    def solve_batch(
        self,
        targets: Iterable[Any],
        *,
        q0: ArrayLike | None = None,
        restarts: int = 0,
        seed: int | None = None,
        max_iterations: int = 1000,
        position_tolerance: float = 1e-6,
        orientation_tolerance: float = 1e-6,
        optimality_tolerance: float = 1e-6,
        until: Until = "stationary",
        progress: Progress = False,
        executor: Executor | None = None,
        block: int = 100,
        threads: int = 1,
        lanes: bool = False,
        save: str | Path | None = None,
    ) -> SolutionBatch:
        """Solve for many targets, each by itself, with the figures of all Solutions as arrays.

        After Ctrl-C the result has the completed rows and ``complete=False``. On a full disk the batch is returned all
        the same, and a warning says that it was not saved.

        Args:
            targets: the targets, each as in `solve`; an array (k, 4, 4) is k poses.
            q0: where to start, one configuration for all, (nq,), or one for each target, (k, nq); `Robot.home` by
                default.
            restarts, seed, max_iterations: of each solve, as in `solve`.
            position_tolerance, orientation_tolerance, optimality_tolerance, until: see the class.
            progress: True for a bar on the terminal, or a function called with (done, total).
            executor: a `concurrent.futures.Executor` for parallel work, such as a process pool or Dask's
                ``client.get_executor()``; the numbers are the same. None solves in this process.
            block: number of targets that are sent to the executor at once.
            threads: number of threads of this process that solve at the same time, with the same numbers. They share
                the work that runs in generated C; a step on the virtual machine, and what a solve leaves to Python, use
                one at a time.
            lanes: whether several targets are solved side by side in vector registers, several times faster. With
                restarts and without a criterion it is a search of its own, in which "damped" takes steps without
                backtracking, far from the target in single precision; so postures differ from those of `solve`. What
                it does not reach is left to the search of `solve`. Otherwise results differ from those of `solve` by
                rounding. Results depend neither on what is solved beside them nor on ``threads`` nor on the width of
                the registers. It compiles C when it is first used, whatever ``compiled`` is.
            save: a ``.npz`` file that is written while the batch runs. If it exists, the batch goes on from it.

        Raises:
            ArgumentError: for an argument of wrong shape, NaN or infinity, naming it, such as ``targets[3]``; for
                ``lanes`` with a strategy that solves quadratic programs, or with what is computed in Python.
            CompilerError: for ``lanes`` without a compiler.
            MissingExtraError: for a bar without rich.
        """
        tolerances = position_tolerance, orientation_tolerance, optimality_tolerance
        options = (restarts, seed, max_iterations, 1, None, *tolerances, until)
        place: dict[str, Any] = {
            "executor": read_executor(executor),
            "block": positive_integer("block", block),
            "threads": positive_integer("threads", threads),
            "lanes": flag("lanes", lanes, "whether several targets are solved side by side in vector registers"),
            "save": save,
        }
        return self._solving.solve_batch(targets, q0, options, progress, solver=self, **place)

    def step(self, q: ArrayLike, target: Any, *, dt: float | None = None) -> Step:
        """One update from ``q``, for controllers; the state of the strategy is kept from call to call.

        Pass the ``q`` of the last step, the commanded configuration, not a measured one: the limits count from
        ``q``. A refused step leaves q where it is, and the next call tries a smaller one. `reset` forgets the state.
        After `warm_up` the first call is as fast as the others, and so is one that escapes from a saddle point.

        With ``dt``, limits of velocity and acceleration hold as well, from ``q`` to the result and from the last step
        with a ``dt`` to this one, and no joint is so fast that it could not stop before its position limits. A moving
        joint cannot stop at once: a refused step then slows the joints down as fast as they can. With limited
        acceleration a target that starts or stops at once is left behind or overshot; it brakes before one that jumps.
        Steps with and without a ``dt`` have separate states.

        Args:
            q: configuration, (nq,). It is clamped to the limits, with ``dt`` as fast as they allow.
            target: the target, as in `solve`.
            dt: duration of the step [s]; None for a step without limits of velocity and acceleration.

        Raises:
            ArgumentError: for an argument of wrong shape, NaN or infinity, naming it, or a dt that is not positive.
        """
        return self._stepping.call(q, target, dt)

    def build(
        self, q: ArrayLike, target: Any, *, qp: str | None = None, program: str | None = None
    ) -> qpsolvers.Problem:
        """A quadratic program of a first step from ``q``, to inspect or to solve elsewhere.

        Args:
            q: configuration, (nq,).
            target: the target, as in `solve`.
            qp: name of the quadratic program, of a strategy that has several; the first by default.
            program: deprecated, use ``qp``.

        Raises:
            ArgumentError: for an argument of wrong shape, NaN or infinity, or a strategy without a quadratic program.
            UnknownNameError: when there is no quadratic program of that name.
        """
        if program is not None:
            warnings.warn("build(program=) is deprecated: use build(qp=)", DeprecationWarning, stacklevel=2)
        return self._engine.build(q, target, program if qp is None else qp)

    def track(
        self,
        targets: Iterable[Any],
        *,
        q0: ArrayLike | None = None,
        dt: float = 0.02,
        max_iterations: int = 100,
        position_tolerance: float = 1e-6,
        orientation_tolerance: float = 1e-6,
        optimality_tolerance: float = 1e-6,
        until: Until = "reached",
        progress: Progress = False,
    ) -> Trajectory:
        """Follow a path of targets; each solve starts where the last one ended.

        Limits of velocity and acceleration hold from one target to the next, from rest at q0. A target that they put
        out of reach is followed as far as they allow. They take the position limits into account, not targets to come:
        with limited acceleration, the end of a path that stops at once is overshot. Ctrl-C ends the path: the result is
        what there is until then, with ``complete`` False.

        Args:
            targets: the targets, each as in `solve`.
            q0: where the robot stands at time 0, (nq,); `Robot.home` by default.
            dt: time from one target to the next [s].
            max_iterations: most steps to try for each target.
            position_tolerance, orientation_tolerance, optimality_tolerance, until: see the class.
            progress: as in `solve_batch`.

        Raises:
            ArgumentError: for an argument of wrong shape, NaN or infinity, naming it.
            MissingExtraError: for a bar without rich.
        """
        tolerances = position_tolerance, orientation_tolerance, optimality_tolerance
        return self._solving.track(targets, q0, dt, (0, None, max_iterations, 1, None, *tolerances, until), progress)
