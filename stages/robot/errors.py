"""Everything that can go wrong, as one tree.

LinkwrightError(message, where, hint)
├── ConfigError
├── SourceError ── AuthError · NotFound · QuotaExhausted · RateLimited · ProtocolError · Offline
├── AssemblyError ── NoRoot · Disconnected · MissingMass
├── MeshError ── EmptyMesh · DecompositionFailed
├── ExportError
└── ValidationFailed

An error has a `message`, a place (`where`: a key, a file, a CAD path) and a `hint` (what to do). A finding of
a stage is a `Diagnostic`: the first letter of its code is its level.
"""

from collections.abc import Iterable
from dataclasses import dataclass

from linkwright.stages.robot.text.printable import sentence


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """One finding about the source, with a stable code.

    `code` starts with its level: `E-` (the robot cannot be built), `W-` (built, but look at it)
    or `I-` (built as asked; worth knowing).
    """

    code: str
    message: str
    where: str = ""
    hint: str = ""

    @property
    def level(self) -> str:
        return {"E": "error", "W": "warning", "I": "info"}[self.code[0]]


class LinkwrightError(Exception):
    """An error that a user can act on; the command line prints it in one message."""

    def __init__(
        self,
        message: str,
        where: str = "",
        hint: str = "",
        problems: Iterable[Diagnostic] = (),
    ) -> None:
        super().__init__(message, where, hint)
        self.message = message
        self.where = where
        self.hint = hint
        self.problems = tuple(problems)

    def __reduce__(self) -> tuple[object, ...]:
        # Exceptions cross process borders in sweeps; the default would lose `problems`.
        return type(self), (self.message, self.where, self.hint, self.problems)

    def __str__(self) -> str:
        lines = [sentence(f"{self.where}: {self.message}" if self.where else self.message)]
        for problem in self.problems:
            place = f" {problem.where}:" if problem.where else ""
            lines.append(sentence(f"  {problem.code}{place} {problem.message}"))
            if problem.hint:
                lines.append(f"      {problem.hint}")
        if self.hint:
            lines.append(f"  → {self.hint}")
        return "\n".join(lines)


class ConfigError(LinkwrightError):
    """The configuration is wrong; known before the first stage runs."""


class SourceError(LinkwrightError):
    """The source of the robot could not be read."""


class AuthError(SourceError):
    """The credentials were refused or do not suffice (401, 403)."""


class NotFound(SourceError):
    """There is nothing at that address for this key (404)."""


class QuotaExhausted(SourceError):
    """The yearly quota of API calls is used up (402)."""


class RateLimited(SourceError):
    """Too many calls in the window (429)."""


class ProtocolError(SourceError):
    """The reply is not what the API promises."""


class Offline(SourceError):
    """The server could not be reached."""


class AssemblyError(LinkwrightError):
    """The assembly does not describe a robot."""


class NoRoot(AssemblyError):
    """No link fits what `root.select` asks for."""


class Disconnected(AssemblyError):
    """Some parts are not connected to the root."""


class MissingMass(AssemblyError):
    """Some parts have no mass."""


class MeshError(LinkwrightError):
    """A mesh could not be made."""


class EmptyMesh(MeshError):
    """A mesh has no triangle."""


class DecompositionFailed(MeshError):
    """A mesh could not be decomposed into convex pieces."""


class ExportError(LinkwrightError):
    """A file could not be written in its format."""


class ValidationFailed(LinkwrightError):
    """The build is complete, but a check failed."""
