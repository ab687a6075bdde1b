"""Defines the interface of the writers of all formats, their input and their output."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Generic, Protocol, TypeVar

from linkwright.stages.formats.robot_json.codec import write
from linkwright.stages.robot.errors import Diagnostic

if TYPE_CHECKING:
    from linkwright.stages.export.configuration.format_section import FormatSection
    from linkwright.stages.export.ground.standing import Placement
    from linkwright.stages.export.section import ExportSections
    from linkwright.stages.formats.robot_json.files import OrderRecord
    from linkwright.stages.formats.written import Written
    from linkwright.stages.robot.model.robot import Robot

Plan = TypeVar("Plan", covariant=True)


@dataclass(frozen=True, slots=True)
class Exported:
    """The result of the export stage."""

    files: Mapping[str, bytes]
    """Path below the output folder → content."""

    diagnostics: tuple[Diagnostic, ...]
    """The losses of the formats, and the remarks of the stage."""

    written: "Written"
    """The robot as it is in the files."""

    advice: str
    """A setting that the user may try; "" without advice."""

    order: "OrderRecord | None"
    """The order of the joints, actuators and sensors in each file."""

    readers: Sequence[Mapping[str, Any]]
    """Features of this robot that other readers drop (`stages.targets.things`)."""

    variants: Mapping[str, Any]
    """The quantities that vary in the robot's variants, and by how much."""

    @property
    def details(self) -> dict[str, Any]:
        """The tables about the files that go to the report."""
        tables = {
            "order": self.order and write(self.order),
            "readers": list(self.readers),
            "variants": self.variants,
        }
        return {name: table for name, table in tables.items() if table}


@dataclass(frozen=True, slots=True)
class WriterInput:
    """The input of a writer."""

    written: "Written"

    keys: "ExportSections"

    standing: "Placement"
    """The placement of the robot in the scene."""

    files: Mapping[str, bytes] = field(default_factory=dict)
    """Path → content of the files of the writers that this writer names in `reads`."""


@dataclass(frozen=True)
class Case(Generic[Plan]):
    """The input for finding the losses of a format (`stages.export.losses`)."""

    format: str

    written: "Written"

    robot: "Robot"
    """The robot as the format has it."""

    where: str
    """The file or folder of the format."""

    plan: Plan
    """The plan of the format's writer."""


@dataclass(frozen=True, slots=True)
class FormatFiles:
    """The output of a writer."""

    files: Mapping[str, bytes]
    """Path → content."""

    cases: tuple[Case[Any], ...] = ()
    """The inputs for finding the losses of the format."""

    diagnostics: tuple[Diagnostic, ...] = ()
    """Diagnostics other than losses."""

    record: Mapping[str, Any] = field(default_factory=dict)
    """Key → the record about the format in robot.json."""


class Writer(Protocol):
    """The writer of one format, in the module `writer` of the folder with the format's name. It has a row in
    `stages.export.writers`, and `conf/export/<name>.yaml` chooses it."""

    @property
    def section(self) -> "type[FormatSection]":
        """The format's part of the configuration, `export.<name>`."""

    @property
    def reads(self) -> tuple[str, ...]:
        """The names of the writers whose files this writer needs. They come before it in the table."""

    @property
    def modules(self) -> tuple[str, ...]:
        """The modules that the writer imports when it runs, if importing them takes long."""

    def write(self, inputs: WriterInput) -> FormatFiles:
        """Returns the files of the format, without the meshes, which all formats share."""
