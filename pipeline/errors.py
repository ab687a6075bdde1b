"""Turns errors into a message and an exit status (see `pipeline.reference.exit_status`)."""

import errno
from collections.abc import Sequence

from linkwright.pipeline import interrupt
from linkwright.pipeline.reference.exit_status import FAILED, INTERRUPTED, REFUSED, UNMET
from linkwright.pipeline.terminal.finding_lines import Style, finding_lines
from linkwright.stages.robot.errors import (
    AssemblyError,
    AuthError,
    ConfigError,
    DecompositionFailed,
    Diagnostic,
    Disconnected,
    EmptyMesh,
    ExportError,
    LinkwrightError,
    MeshError,
    MissingMass,
    NoRoot,
    NotFound,
    Offline,
    ProtocolError,
    QuotaExhausted,
    RateLimited,
    SourceError,
    ValidationFailed,
)

__all__ = [
    "AssemblyError",
    "AuthError",
    "CacheError",
    "ConfigError",
    "DecompositionFailed",
    "Diagnostic",
    "Disconnected",
    "EmptyMesh",
    "ExportError",
    "InTheWay",
    "LinkwrightError",
    "MeshError",
    "MissingMass",
    "NoRoot",
    "NotFound",
    "Offline",
    "OutputError",
    "ProtocolError",
    "QuotaExhausted",
    "RateLimited",
    "SecretFound",
    "SourceError",
    "ValidationFailed",
    "as_problems",
    "exit_status",
    "reason",
    "refusal",
    "render",
]


class CacheError(LinkwrightError):
    """The cache folder cannot be used."""


class OutputError(LinkwrightError):
    """The output folder cannot be used."""


class SecretFound(LinkwrightError):
    """A file that was about to be written holds an API key."""


class InTheWay(OutputError):
    """The result cannot be moved into the output folder: a file that is not linkwright's is in the way."""


REPORTED_STYLE = Style("-v shows all", indent="  ", hint="    ")
"""Style of the problems of a stage on the terminal, where only the worst are shown: its report lists all."""

DISK_FULL_TEXTS = {errno.ENOSPC: "the disk is full", errno.EDQUOT: "the disk quota is used up"}
"""Errors of a full disk: errno → text."""


def reason(error: OSError) -> str:
    """Returns the system's reason for an error, as text."""
    return DISK_FULL_TEXTS.get(error.errno or 0) or error.strerror or str(error)


def refusal(problems: Sequence[Diagnostic], subject: str = "the configuration") -> ConfigError:
    """Returns a ConfigError that lists all problems of `subject`."""
    count = "a problem" if len(problems) == 1 else f"{len(problems)} problems"
    msg = f"{subject} has {count}"
    return ConfigError(msg, problems=problems)


def as_problems(error: ConfigError) -> tuple[Diagnostic, ...]:
    """Returns the problems that an error lists, or the error itself as one problem."""
    return error.problems or (Diagnostic("E-VALUE", error.message, error.where, error.hint),)


def exit_status(error: BaseException) -> int:
    """Returns the exit status of a run that `error` ended."""
    if isinstance(error, ConfigError):
        return REFUSED
    if isinstance(error, ValidationFailed):
        return UNMET
    if isinstance(error, KeyboardInterrupt):
        return INTERRUPTED
    return FAILED


def render(error: BaseException, *, whole: bool = True) -> str:
    """Returns the message of `error` with its place, hint and notes, without a traceback. If not `whole`,
    only the worst problems of each code are shown for a stage, whose report lists all."""
    notes = getattr(error, "__notes__", ())
    message = _message(error)
    if isinstance(error, LinkwrightError) and not whole and not isinstance(error, ConfigError):
        hint = [f"  → {error.hint}"] if error.hint else []
        message = "\n".join(
            [message.partition("\n")[0], *finding_lines(error.problems, REPORTED_STYLE), *hint]
        )
    return "\n".join([message, *(f"  {note}" for note in notes)])


def _message(error: BaseException) -> str:
    if isinstance(error, KeyboardInterrupt):
        return interrupt.MESSAGE
    if isinstance(error, LinkwrightError):
        return f"error: {error}"
    if isinstance(error, OSError) and (error.filename or error.errno in DISK_FULL_TEXTS):
        return f"error: {error.filename or 'a file cannot be written'}: {reason(error)}"
    return (
        f"error: a bug in linkwright: {type(error).__name__}: {error}\n"
        "  → LINKWRIGHT_TRACEBACK=1 shows where; so does build.log in the <output>.failed folder"
    )
