"""The interface of the writers of all formats."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Generic, Protocol, TypeVar

from linkwright.stages.robot.errors import Diagnostic

if TYPE_CHECKING:
    from linkwright.stages.export.configuration.format_section import FormatSection
    from linkwright.stages.export.ground.standing import Stance
    from linkwright.stages.export.section import ExportSections
    from linkwright.stages.formats.robot_json.files import OrderRecord
    from linkwright.stages.formats.written import Written
    from linkwright.stages.robot.model.robot import Robot

Plan = TypeVar("Plan", covariant=True)


@dataclass(frozen=True, slots=True)
class Exported:
    """`files`: path below the output folder → bytes. `diagnostics`: losses of the formats. `written`: the
    robot as it is in the files; `advice`: what a user may want to try; `order`: of the joints,
    actuators and sensors in each file; `readers`: what other readers drop of this robot
    (`stages.export.readers`)."""

    files: Mapping[str, bytes]
    diagnostics: tuple[Diagnostic, ...]
    written: "Written"
    advice: str
    order: "OrderRecord | None"
    readers: Sequence[Mapping[str, Any]]

    @property
    def details(self) -> dict[str, Any]:
        """What the report tells of the files."""
        # Late: the table of writers is read by builds that write nothing.
        from linkwright.stages.formats.robot_json.codec import write

        tables = {"order": self.order and write(self.order), "readers": list(self.readers)}
        return {name: table for name, table in tables.items() if table}


@dataclass(frozen=True, slots=True)
class WriterInput:
    """The input of a writer.

    `standing`: where the scene puts the robot. `files`: the files of the writers that this one names in
    `reads`, by path.
    """

    written: "Written"
    keys: "ExportSections"
    standing: "Stance"
    files: Mapping[str, bytes] = field(default_factory=dict)


@dataclass(frozen=True)
class Case(Generic[Plan]):
    """What the losses of a format are found in (`stages.export.losses`). `robot`: as the format has
    it; `where`: the file or folder of the format; `plan`: what its writer works out before it writes."""

    format: str
    written: "Written"
    robot: "Robot"
    where: str
    plan: Plan


@dataclass(frozen=True, slots=True)
class FormatFiles:
    """`files`: by path; `cases`: in which the format may have losses; `diagnostics`: what else is worth
    knowing; `record`: the records of robot.json that tell of the format, by key."""

    files: Mapping[str, bytes]
    cases: tuple[Case[Any], ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()
    record: Mapping[str, Any] = field(default_factory=dict)


class Writer(Protocol):
    """One format: a row of `stages.export.writers`, in the module `writer` of the folder that has its name;
    `conf/export/<name>.yaml` chooses it."""

    @property
    def section(self) -> "type[FormatSection]":
        """The format's part of the configuration, `export.<name>`."""

    @property
    def reads(self) -> tuple[str, ...]:
        """The names of the writers whose files this one needs; they come before it in the table."""

    @property
    def modules(self) -> tuple[str, ...]:
        """The modules that it imports when it runs, as far as importing them takes time."""

    def write(self, given: WriterInput) -> FormatFiles:
        """Its files, without the meshes, which all formats share."""
