"""The interface of the writers of all formats."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

from stages.formats.mjcf_form import AS_IS as EVERY_BODY
from stages.formats.mjcf_form import MjcfForm
from stages.formats.urdf.form import AS_IS, UrdfForm
from stages.robot.amendments import UNCHANGED, Amendments
from stages.robot.errors import Diagnostic
from stages.robot.scene import Scene
from stages.robot.sensing import NOTHING, Sensing

if TYPE_CHECKING:
    from stages.export.keys import ExportKeys
    from stages.export.standing import Stance
    from stages.robot.actuation import Actuation
    from stages.robot.geometry import Geometry
    from stages.robot.model import Configuration, Robot


@dataclass(frozen=True, slots=True)
class Exported:
    """`files`: path below the output folder → bytes. `diagnostics`: losses of the format. `actuation`: what
    drives the robot in the files; `advice`: what a user may want to try; `form`: of the URDF;
    `mjcf_form`: of the MJCF; `order`: the tables of joints, actuators and sensors by format;
    `sensing`: what measures the robot in the files; `amendments`: what the user's own XML changed in them;
    `record`: the tables of robot.json that tell of the format, by name; `readers`: what other readers drop of
    this robot (`stages.export.readers`); `scene`: where the files put it."""

    files: Mapping[str, bytes]
    diagnostics: tuple[Diagnostic, ...] = ()
    actuation: "Actuation | None" = None
    advice: str = ""
    form: UrdfForm = AS_IS
    mjcf_form: MjcfForm = EVERY_BODY
    order: Mapping[str, Any] = field(default_factory=dict)
    sensing: Sensing = NOTHING
    amendments: Amendments = UNCHANGED
    record: Mapping[str, Any] = field(default_factory=dict)
    readers: Sequence[Mapping[str, Any]] = ()
    scene: Scene | None = None

    @property
    def details(self) -> dict[str, Any]:
        """What the report tells of the files."""
        tables = {"order": self.order, "readers": list(self.readers)}
        return {name: table for name, table in tables.items() if table}


@dataclass(frozen=True, slots=True)
class WriterInput:
    """The input of a writer.

    `start`: the value of every dof in a fresh simulation (qpos0). `files`: the files of the writers that this
    one names in `reads`, by path. `standing`: where the scene puts the robot. `form`: that of its URDF;
    `mjcf_form`: that of its MJCF. `sensing`: what measures it.
    """

    robot: "Robot"
    geometry: "Geometry"
    keys: "ExportKeys"
    start: "Configuration"
    files: Mapping[str, bytes]
    actuation: "Actuation"
    standing: "Stance"
    form: UrdfForm = AS_IS
    mjcf_form: MjcfForm = EVERY_BODY
    sensing: Sensing = NOTHING


class Writer(Protocol):
    """One format: `WRITER` of the module `writer` in the folder that has the format's name.

    Beside it lies `keys`, whose `KEYS` is the format's section of the configuration (`export.<name>`), and
    `conf/export/<name>.yaml` chooses it.
    """

    @property
    def reads(self) -> tuple[str, ...]:
        """The names of the writers whose files this one needs; they come before it in the table."""

    @property
    def modules(self) -> tuple[str, ...]:
        """The modules that it imports when it runs, as far as importing them takes time."""

    def paths(self, robot: str) -> tuple[str, ...]:
        """The paths of its files for a robot of this name."""

    def write(self, given: WriterInput) -> Exported:
        """Its files, without the meshes, which all formats share."""
