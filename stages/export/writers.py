"""Lists the writers of all formats."""

from linkwright.stages.export.mjcf.writer import MjcfWriter
from linkwright.stages.export.python.writer import PythonWriter
from linkwright.stages.export.ros2.writer import Ros2Writer
from linkwright.stages.export.sdf.writer import SdfWriter
from linkwright.stages.export.urdf.writer import UrdfWriter
from linkwright.stages.export.usd.writer import UsdWriter
from linkwright.stages.export.writer import Writer

WRITERS: dict[str, Writer] = {
    "urdf": UrdfWriter(),
    "mjcf": MjcfWriter(),
    "sdf": SdfWriter(),
    "ros2": Ros2Writer(),
    "usd": UsdWriter(),
    "python": PythonWriter(),
}
"""Format → its writer, in the order of `stages.export.section`."""
