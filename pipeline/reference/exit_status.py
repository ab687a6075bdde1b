"""Defines the exit status of every command, the only place that does. Imports nothing heavy."""

from textwrap import fill

from linkwright.pipeline import interrupt

BUILT = 0
"""Done: built and valid, equal, passed."""

FAILED = 1
"""Failed after the command began its work."""

REFUSED = 2
"""Wrong usage or configuration, found before the work began: nothing was done."""

UNMET = 3
"""Done, with a result that is not as it should be: a check failed, a difference was found."""

INTERRUPTED = interrupt.STATUS
"""Interrupted by Ctrl-C, as shells report it."""

_USAGE = "wrong usage"
_BUILD = {
    BUILT: "built and valid",
    FAILED: "failed",
    REFUSED: "wrong configuration, nothing was built",
    UNMET: "built, but a check failed, or the state is not the newest (the API quota is used up)",
}

MEANINGS = {
    "build": _BUILD,
    "sweep": {
        BUILT: "all jobs are built and valid",
        FAILED: "a job failed",
        REFUSED: "wrong configuration, nothing was built",
        UNMET: "a check of a job failed; a search has the status of its best job",
    },
    "bundle": {BUILT: "packed", FAILED: "failed (the cache no longer has it)", REFUSED: _USAGE},
    "cache": {
        BUILT: "done",
        FAILED: "verify found corrupt files, or the folder cannot be used",
        REFUSED: _USAGE,
    },
    "check": {BUILT: "passed", FAILED: "a file cannot be read", REFUSED: _USAGE, UNMET: "a check failed"},
    "diff": {BUILT: "equal", FAILED: "a robot cannot be read", REFUSED: _USAGE, UNMET: "different"},
    "doctor": {BUILT: "nothing is wrong", FAILED: "something is wrong", REFUSED: _USAGE},
    "explain": {BUILT: "explained", REFUSED: "nothing has this name"},
    "job": {**_BUILD, REFUSED: "wrong usage, no list, or a list that is stale"},
    "jobs": {
        BUILT: "all are built and valid (with --fetch: all is fetched)",
        FAILED: "a job failed, or is not done",
        REFUSED: "wrong usage, or no list",
        UNMET: "a check failed",
    },
    "new": {
        BUILT: "written, also if the build will end with problems",
        FAILED: "failed",
        REFUSED: "wrong usage, no API key, no such file, or there is a robot of that name",
    },
    "skill": {BUILT: "printed", REFUSED: _USAGE},
    "snapshot": {
        BUILT: "written, or as they were",
        FAILED: "a robot cannot be built",
        REFUSED: "wrong usage, or a configuration is wrong",
        UNMET: "--check found a difference",
    },
    "view": {BUILT: "the viewer was closed", FAILED: "there is no display, or no scene", REFUSED: _USAGE},
}
"""Command (`build` and `sweep`: without a verb) → exit status → its meaning. All have INTERRUPTED, too."""


def paragraph(command: str) -> str:
    """Returns the exit status of a command in lines of 80 columns."""
    return fill(line(command), 80, break_on_hyphens=False)


def line(command: str) -> str:
    """Returns the exit status of a command as a sentence."""
    meanings = {**MEANINGS[command], INTERRUPTED: "interrupted"}
    return f"exit status: {'; '.join(f'{status} {meaning}' for status, meaning in meanings.items())}"


def table() -> str:
    """Returns the exit status of all commands, a line each."""
    return "\n".join(f"{name}: {line(name).removeprefix('exit status: ')}" for name in MEANINGS)
