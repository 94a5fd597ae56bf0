"""MuJoCo as the judge of self-collision: the bodies of a robot as capsules, each at its place."""

from __future__ import annotations

import mujoco
import numpy as np


class Judge:
    """The distances of pairs of a robot's bodies, measured by MuJoCo at places that the robot's poses give."""

    def __init__(self, robot, pairs):
        self.robot = robot
        self.bodies = list(pairs.bodies.values())
        order = {body.name: i for i, body in enumerate(self.bodies)}
        self.pairs = [(order[pair.first], order[pair.second]) for pair in pairs]
        q = robot.neutral
        geoms = []
        for body in self.bodies:
            start, end = self.ends(q, body)
            half = np.linalg.norm(end - start) / 2
            shape = (
                f'type="capsule" size="{body.radius:.17g} {half:.17g}"' if half > 1e-9 else f'size="{body.radius:.17g}"'
            )
            geoms.append(f'<body mocap="true"><geom {shape}/></body>')
        self.model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{''.join(geoms)}</worldbody></mujoco>")
        self.data = mujoco.MjData(self.model)

    def ends(self, q, body):
        """Start and end of a body's axis, (3,) [m] each."""
        for frame, offset in zip(body.frames, body.offsets, strict=True):
            pose = self.robot.pose(q, frame)
            yield pose[:3, :3] @ offset + pose[:3, 3]

    def distances(self, q):
        """The distance of each pair [m]."""
        for i, body in enumerate(self.bodies):
            start, end = self.ends(q, body)
            self.data.mocap_pos[i] = (start + end) / 2
            if np.linalg.norm(end - start) > 1e-9:
                mujoco.mju_quatZ2Vec(self.data.mocap_quat[i], (end - start) / np.linalg.norm(end - start))
        mujoco.mj_kinematics(self.model, self.data)
        return np.array([mujoco.mj_geomDistance(self.model, self.data, i, j, 100.0, None) for i, j in self.pairs])
