"""Describes the changes of exported files by the configuration's own XML."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Amendment:
    """The change of a file by an entry of `elements` or `attributes`.

    key: the key of the entry.
    file: the path of the file.
    target: the element that was changed, or got new children, such as "body torso".
    adds: the elements that were added, such as "site cam".
    sets: the names of the attributes that were set or removed.
    """

    key: str
    file: str
    target: str
    adds: tuple[str, ...] = ()
    sets: tuple[str, ...] = ()

    @property
    def added_tags(self) -> frozenset[str]:
        """The tags of the elements that were added."""
        return frozenset(map(tag_of, self.adds))


def tag_of(description: str) -> str:
    """Returns the tag of an element from its description: "body torso", or "<body>" if it is unnamed."""
    return description.split()[0].strip("<>")


@dataclass(frozen=True, slots=True)
class Surplus:
    """The numbers of elements that amendments add to a file. They come after the robot's own.

    file: the path of the file.
    dofs: the number of degrees of freedom.
    actuators: the number of actuators.
    equalities: the number of equalities.
    """

    file: str
    dofs: int = 0
    actuators: int = 0
    equalities: int = 0


@dataclass(frozen=True, slots=True)
class Amendments:
    """All amendments of a build."""

    changes: tuple[Amendment, ...] = ()
    """The amendments, in the order in which they were made."""
    surplus: tuple[Surplus, ...] = ()
    """The surplus of each file that has one."""

    def surplus_of(self, file: str) -> Surplus:
        """Returns the surplus of a file; zeros if it has none."""
        return next((surplus for surplus in self.surplus if surplus.file == file), Surplus(file))

    def changes_of(self, *files: str) -> tuple[Amendment, ...]:
        """Returns the changes of these files."""
        return tuple(amendment for amendment in self.changes if amendment.file in files)


UNCHANGED = Amendments()
"""The amendments of a build without any: its files are as they were written."""
