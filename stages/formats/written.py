"""Defines the content of a robot's files: writers write it, and checks compare files with it."""

from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Any

import orjson

from linkwright.stages.formats.mjcf.form import MjcfForm
from linkwright.stages.formats.mjcf.written import mjcf_robot
from linkwright.stages.formats.urdf.form import UrdfForm
from linkwright.stages.formats.urdf.names import UrdfNames, urdf_names
from linkwright.stages.formats.urdf.srdf_form import SrdfForm
from linkwright.stages.formats.urdf.urdf_robot import urdf_robot
from linkwright.stages.robot import codec
from linkwright.stages.robot.dynamics.driven import with_actuation
from linkwright.stages.robot.dynamics.fused_geometry import fused_geometry
from linkwright.stages.robot.dynamics.fusing import Holders, holders, links_on_fixed_joints
from linkwright.stages.robot.model.actuation import NONE, Actuation
from linkwright.stages.robot.model.amendments import UNCHANGED, Amendments
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.mjcf_extras import NO_EXTRAS, MjcfExtras
from linkwright.stages.robot.model.robot import Configuration, Robot
from linkwright.stages.robot.model.scene import Scene
from linkwright.stages.robot.model.sensing import NOTHING, Sensing
from linkwright.stages.robot.motion.start_pose import starting_point

NO_SHAPES = Geometry((), {})

_FIELDS_OF_EARLIER_STAGES = ("robot", "geometry")
"""The fields of `Written` that are not encoded, as earlier stages keep them."""


@dataclass(frozen=True, slots=True, eq=False)
class FormatView:
    """The robot that the files of a format describe."""

    robot: Robot
    held: Holders
    """Link of the whole robot → the link in the format that contains it, and holder_from_link (4, 4)."""


@dataclass(frozen=True, eq=False)
class Written:
    """The content of a robot's files."""

    robot: Robot
    """The robot, with the dynamics that its motors give the dofs."""

    actuation: Actuation = NONE
    geometry: Geometry | None = None
    """The shapes; None if they are unknown."""

    urdf_form: UrdfForm = field(default_factory=UrdfForm)
    """How the URDF differs from the robot."""

    mjcf_form: MjcfForm = field(default_factory=MjcfForm)
    """How the MJCF differs from the robot."""

    sensing: Sensing = NOTHING
    amendments: Amendments = UNCHANGED
    """The changes of the files by the user's own XML."""

    scene: Scene | None = None
    """The scene of the files; None if it is unknown."""

    srdf_form: SrdfForm | None = None
    """The content that only the SRDF has; None without an SRDF."""

    @cached_property
    def start(self) -> Configuration:
        """The value of every dof in a fresh simulation (qpos0)."""
        return starting_point(self.robot)

    @cached_property
    def as_urdf(self) -> FormatView:
        """The robot that the URDF describes."""
        held = holders(self.robot, links_on_fixed_joints(self.robot) if self.urdf_form.merged else ())
        return FormatView(urdf_robot(self.robot, self.urdf_form, held), held)

    @cached_property
    def as_mjcf(self) -> FormatView:
        """The robot that the MJCF describes."""
        held = holders(self.robot, self.mjcf_form.fused)
        return FormatView(mjcf_robot(self.robot, self.mjcf_form, held), held)

    @cached_property
    def urdf_names(self) -> UrdfNames:
        """The names of the URDF's extra links and joints."""
        return urdf_names(self.as_urdf.robot)

    @property
    def shapes(self) -> Geometry:
        """The geometry; without any shape if it is unknown."""
        return self.geometry or NO_SHAPES

    @cached_property
    def mjcf_shapes(self) -> Geometry:
        """The shapes, each on the link that has its body in the MJCF."""
        return fused_geometry(self.robot, self.shapes, self.as_mjcf.held)

    @property
    def extras(self) -> MjcfExtras:
        """The content of the MJCF that no other format has."""
        return self.mjcf_form.extras or NO_EXTRAS


def encode(written: Written) -> bytes:
    """Returns as JSON the values that the export adds to the robot and its geometry."""
    names = [entry.name for entry in fields(Written) if entry.name not in _FIELDS_OF_EARLIER_STAGES]
    return codec.dump({name: getattr(written, name) for name in names})


def decode(data: bytes, robot: Robot, geometry: Geometry) -> Written:
    """Returns the content of the files from the output of `encode`, the robot of the graph stage, and the
    geometry of the mesh stage."""
    field_types, table = codec.field_types_of(Written), orjson.loads(data)
    added: dict[str, Any] = {name: codec.typed(field_types[name], value) for name, value in table.items()}
    return Written(with_actuation(robot, added["actuation"]), geometry=geometry, **added)
