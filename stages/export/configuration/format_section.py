"""What the configurations of all formats have."""

from typing import ClassVar

from linkwright.stages.robot.section import Section


class FormatSection(Section):
    """`files`: the paths of the format's files, with `<name>` where the robot's name goes."""

    files: ClassVar[tuple[str, ...]] = ()

    @classmethod
    def paths(cls, robot: str) -> tuple[str, ...]:
        """The paths of the files of a robot of this name."""
        return tuple(file.replace("<name>", robot) for file in cls.files)
