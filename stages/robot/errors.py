"""Defines the tree of all errors.

LinkwrightError(message, where, hint)
├── ConfigError
├── SourceError ── AuthError · NotFound · QuotaExhausted · RateLimited · ProtocolError · Offline
├── AssemblyError ── NoRoot · Disconnected · MissingMass
├── MeshError ── EmptyMesh · DecompositionFailed
├── ExportError
└── ValidationFailed

An error has a `message`, a place (`where`: a key, a file or a CAD path) and a `hint` (what to do). A stage
reports a `Diagnostic` for each thing that it notices; the first letter of its code is its level.
"""

from collections.abc import Iterable
from dataclasses import dataclass

from linkwright.stages.robot.text.printable import sentence


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """A finding of a stage, with a stable code."""

    code: str
    """The code, which starts with the level: `E-` (the robot cannot be built), `W-` (it was built, but look
    at it) or `I-` (it was built as asked, and this is worth knowing)."""
    message: str
    where: str = ""
    """The place: a key, a file or a CAD path; "" without a place."""
    hint: str = ""
    """What to do; "" without a hint."""

    @property
    def level(self) -> str:
        """The level of the code: "error", "warning" or "info"."""
        return {"E": "error", "W": "warning", "I": "info"}[self.code[0]]


class LinkwrightError(Exception):
    """An error that a user can act on. `problems` are the findings that led to it, printed below the
    message."""

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
        # Sweeps pass exceptions between processes; by default pickling would lose `problems`.
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
    """An error in the configuration, found before the first stage runs."""


class SourceError(LinkwrightError):
    """An error of a source that cannot be read."""


class AuthError(SourceError):
    """An error of credentials that are refused or do not suffice (401, 403)."""


class NotFound(SourceError):
    """An error of an address where there is nothing that the API key may read (404)."""


class QuotaExhausted(SourceError):
    """An error of a yearly quota of API calls that is used up (402)."""


class RateLimited(SourceError):
    """An error of too many calls in a short time (429)."""


class ProtocolError(SourceError):
    """An error of a reply that is not what the API promises."""


class Offline(SourceError):
    """An error of a server that cannot be reached."""


class AssemblyError(LinkwrightError):
    """An error of an assembly that does not describe a robot."""


class NoRoot(AssemblyError):
    """An error of an assembly whose root link cannot be chosen."""


class Disconnected(AssemblyError):
    """An error of parts that are not connected to the root."""


class MissingMass(AssemblyError):
    """An error of parts that have no mass."""


class MeshError(LinkwrightError):
    """An error of a mesh that cannot be made."""


class EmptyMesh(MeshError):
    """An error of a mesh that has no triangles."""


class DecompositionFailed(MeshError):
    """An error of a mesh that cannot be decomposed into convex pieces."""


class ExportError(LinkwrightError):
    """An error of a file that cannot be written in its format."""


class ValidationFailed(LinkwrightError):
    """An error of a complete build in which a check failed."""
