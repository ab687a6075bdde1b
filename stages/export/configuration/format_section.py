"""Defines the base of the configurations of all formats."""

from typing import ClassVar

from linkwright.stages.robot.section import Section


class FormatSection(Section):
    """`files`: the paths of the format's files, with `<name>` where the robot's name goes."""

    files: ClassVar[tuple[str, ...]] = ()

    @classmethod
    def paths(cls, robot: str) -> tuple[str, ...]:
        """Returns the paths of the files of a robot with this name."""
        return tuple(file.replace("<name>", robot) for file in cls.files)
