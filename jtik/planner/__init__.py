"""The interactive trajectory planner: an operator guides the end effector of a robot through obstacles.

`Planner` is a session. `jtik.planner.edits.messages` and `jtik.planner.edits.of_attempts` are what it can be asked for,
`jtik.planner.session.frames` what it publishes.
"""

from jtik.planner.planner import Planner

__all__ = ["Planner"]
