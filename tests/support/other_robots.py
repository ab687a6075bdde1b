"""The robots of others, and the sample: where they come from, and what is seen of their parts."""

from tests.support.places import SHARED

_HERE = SHARED / "data" / "robots"

FILES = {
    "so101": ("urdf", _HERE / "so101/Simulation/SO101/so101_new_calib.urdf"),
    "duck": ("urdf", _HERE / "open_duck_mini_bdx/mini_bdx/robots/bdx/robot.urdf"),
    "reachy2": ("mjcf", _HERE / "reachy2/reachy2_mujoco/description/mjcf/reachy2.xml"),
}

ROBOTS = ("sample", *FILES)

AS_IT_IS = ("mesh.visual.max_faces=2000000",)
"""For tests of anything but visual meshes: decimating those of a real robot takes a minute."""


def is_here(name):
    return name not in FILES or FILES[name][1].exists()


def source_of(name):
    """The overrides that choose a robot."""
    if name not in FILES:
        return [f"robot={name}"]
    kind, path = FILES[name]
    return [f"source={kind}", f"source.path={path}"]
