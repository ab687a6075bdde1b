"""The robot as its files have it: what writers write, readers read back, and checks compare with."""

from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Any

import orjson

from linkwright.stages.formats.mjcf.form import MjcfForm
from linkwright.stages.formats.mjcf.written import as_written as as_in_mjcf
from linkwright.stages.formats.urdf.as_written import as_written as as_in_urdf
from linkwright.stages.formats.urdf.form import UrdfForm
from linkwright.stages.formats.urdf.names import UrdfNames, urdf_names
from linkwright.stages.formats.urdf.srdf_form import SrdfForm
from linkwright.stages.robot import codec
from linkwright.stages.robot.dynamics.driven import as_driven
from linkwright.stages.robot.dynamics.fused_geometry import fused_geometry
from linkwright.stages.robot.dynamics.fusing import Holders, holders, on_fixed_joints
from linkwright.stages.robot.model.actuation import NONE, Actuation
from linkwright.stages.robot.model.amendments import UNCHANGED, Amendments
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.mjcf_extras import NO_EXTRAS, MjcfExtras
from linkwright.stages.robot.model.robot import Configuration, Robot
from linkwright.stages.robot.model.scene import Scene
from linkwright.stages.robot.model.sensing import NOTHING, Sensing
from linkwright.stages.robot.motion.start_pose import starting_point

NO_SHAPES = Geometry((), {})

_OF_EARLIER_STAGES = ("robot", "geometry")


@dataclass(frozen=True, slots=True, eq=False)
class FormatView:
    """The robot that the files of one format describe. `held`: by link of the whole robot, the link there
    that it is part of, and holder_from_link (4, 4)."""

    robot: Robot
    held: Holders


@dataclass(frozen=True, eq=False)
class Written:
    """`robot`: with what its motors give the dofs; `actuation`: what drives it; `geometry`: its shapes, None
    where these are unknown; `urdf_form` and `mjcf_form`: how these files differ from the robot; `sensing`:
    what measures it; `amendments`: what the user's own XML changed in the files; `scene`: where the files put
    the robot, None where nothing is known of that; `srdf_form`: what only the SRDF says, None for nothing."""

    robot: Robot
    actuation: Actuation = NONE
    geometry: Geometry | None = None
    urdf_form: UrdfForm = field(default_factory=UrdfForm)
    mjcf_form: MjcfForm = field(default_factory=MjcfForm)
    sensing: Sensing = NOTHING
    amendments: Amendments = UNCHANGED
    scene: Scene | None = None
    srdf_form: SrdfForm | None = None

    @cached_property
    def start(self) -> Configuration:
        """The value of every dof in a fresh simulation (qpos0)."""
        return starting_point(self.robot)

    @cached_property
    def as_urdf(self) -> FormatView:
        held = holders(self.robot, on_fixed_joints(self.robot) if self.urdf_form.merged else ())
        return FormatView(as_in_urdf(self.robot, self.urdf_form, held), held)

    @cached_property
    def as_mjcf(self) -> FormatView:
        held = holders(self.robot, self.mjcf_form.fused)
        return FormatView(as_in_mjcf(self.robot, self.mjcf_form, held), held)

    @cached_property
    def urdf_names(self) -> UrdfNames:
        return urdf_names(self.as_urdf.robot)

    @property
    def shapes(self) -> Geometry:
        """The geometry; without any shape where it is unknown."""
        return self.geometry or NO_SHAPES

    @cached_property
    def mjcf_shapes(self) -> Geometry:
        """The shapes by the links that have bodies in the MJCF."""
        return fused_geometry(self.robot, self.shapes, self.as_mjcf.held)

    @property
    def extras(self) -> MjcfExtras:
        """What the MJCF has that no other format has."""
        return self.mjcf_form.extras or NO_EXTRAS


def encode(written: Written) -> bytes:
    """What the export adds to the robot and its geometry, which earlier stages keep."""
    names = [own.name for own in fields(Written) if own.name not in _OF_EARLIER_STAGES]
    return codec.dump({name: getattr(written, name) for name in names})


def decode(data: bytes, robot: Robot, geometry: Geometry) -> Written:
    """The value of which `encode` wrote the rest. `robot`: as the graph stage made it."""
    known, table = codec.hints(Written), orjson.loads(data)
    added: dict[str, Any] = {name: codec.typed(known[name], value) for name, value in table.items()}
    return Written(as_driven(robot, added["actuation"]), geometry=geometry, **added)
