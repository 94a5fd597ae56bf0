"""The interactive trajectory planner: an operator guides the end effector of a robot through obstacles.

`Planner` is a session. `jtik.planner.edits` and `jtik.planner.edits_of_attempts` are what it can be asked for,
`jtik.planner.frames` what it publishes.
"""

from jtik.planner.planner import Planner

__all__ = ["Planner"]
