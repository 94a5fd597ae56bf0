"""Load a URDF, see what jtik made of it, reach a target, and learn why another one cannot be reached.

python examples/your_urdf.py [arm.urdf]         a path, or the name of a file of example-robot-data: ur10_robot.urdf
"""

import sys
from importlib import metadata
from pathlib import Path

import jtik

ARM = """
<robot name="two_and_a_half">
  <link name="base"/><link name="column"/><link name="upper"/><link name="forearm"/><link name="tool0"/>
  <joint name="lift" type="prismatic"><parent link="base"/><child link="column"/><axis xyz="0 0 1"/>
    <limit lower="0" upper="0.5" velocity="0.3" effort="100"/></joint>
  <joint name="shoulder" type="revolute"><parent link="column"/><child link="upper"/><origin xyz="0 0 0.3"/>
    <axis xyz="0 0 1"/><limit lower="-2.5" upper="2.5" velocity="2" effort="50"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="forearm"/><origin xyz="0.35 0 0"/>
    <axis xyz="0 0 1"/><limit lower="-2.6" upper="2.6" velocity="2" effort="50"/></joint>
  <joint name="flange" type="fixed"><parent link="forearm"/><child link="tool0"/><origin xyz="0.3 0 0"/></joint>
</robot>
"""


def find(name):
    """The path, or the file of that name in the package example-robot-data, which has many robots."""
    if Path(name).exists():
        return name
    try:
        files = metadata.files("example-robot-data")
    except ImportError:
        raise SystemExit(f"{name} does not exist; robots to try: python -m pip install 'jtik[robots]'") from None
    return next((str(file.locate()) for file in files if file.name == name), name)


robot = jtik.Robot.from_urdf(find(sys.argv[1]) if len(sys.argv) > 1 else ARM)
print(robot)
print("joints:", *robot.joint_names)
print("tip:", robot.tip, "  ignored:", robot.ignored or "nothing")

ik = jtik.InverseKinematics(robot, jtik.FrameTask("tip"))
reachable = robot.position(robot.random_configuration(1))
solution = ik.solve(reachable, restarts=20)
print(solution)
assert solution.status.on_target

print("\nand 10 m away:")
far = ik.solve([10.0, 0.0, 0.5], restarts=20)
print(far)  # the status, what is left of the error, and the limits that are active
assert not far
