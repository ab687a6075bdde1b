"""What the configuration's own XML changed in the exported files, for who checks and describes them."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Amendment:
    """What one entry of `elements` or `attributes` did to a file.

    key: of the entry.
    file: the path of the file.
    target: the element that was added to or changed, "body torso".
    adds: the elements that were added, "site cam".
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


def tag_of(said: str) -> str:
    """The tag of an element in words: "body torso", or "<body>" of one without a name."""
    return said.split()[0].strip("<>")


@dataclass(frozen=True, slots=True)
class Surplus:
    """How many things a file has that are not the robot's own: they come after these.

    file: the path of the file.
    dofs: number of degrees of freedom.
    actuators: number of actuators.
    equalities: number of equalities.
    """

    file: str
    dofs: int = 0
    actuators: int = 0
    equalities: int = 0


@dataclass(frozen=True, slots=True)
class Amendments:
    """All amendments, in the order in which they were made, and what they add to each file."""

    changes: tuple[Amendment, ...] = ()
    surplus: tuple[Surplus, ...] = ()

    def surplus_of(self, file: str) -> Surplus:
        return next((one for one in self.surplus if one.file == file), Surplus(file))

    def of(self, *files: str) -> tuple[Amendment, ...]:
        """What was done to these files."""
        return tuple(one for one in self.changes if one.file in files)


UNCHANGED = Amendments()
"""The files are as they were written."""
