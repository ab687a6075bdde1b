"""Reads a file of a revision from git, without running programs that the repository's configuration names.

A repository may come from anywhere, and its configuration can name programs: hooks, filters, text converters,
pagers, helpers of remotes. `cat-file` starts only the helper of a remote from which git fetches missing files
(git-config(1), `remote.<name>.promisor`), and no protocol is allowed here.
"""

import os
import subprocess

from linkwright.pipeline.errors import OutputError
from linkwright.stages.robot.system.programs import program

_MAX_SECONDS = 60
"""Largest time [s] that git may take."""

_SETTINGS = (
    "protocol.allow=never",
    f"core.hooksPath={os.devnull}",
    "core.fsmonitor=false",
    "credential.helper=",
)

_ENVIRONMENT = {
    "GIT_ALLOW_PROTOCOL": "none",
    "GIT_NO_LAZY_FETCH": "1",
    "GIT_OPTIONAL_LOCKS": "0",
    "GIT_TERMINAL_PROMPT": "0",
    "LC_ALL": "C",
}
_REMOVED_VARIABLES = (
    "GIT_EXTERNAL_DIFF",
    "GIT_SSH",
    "GIT_SSH_COMMAND",
    "GIT_ASKPASS",
    "GIT_PROXY_COMMAND",
    "GIT_PAGER",
)


def read_blob(name: str, hint: str) -> "subprocess.CompletedProcess[bytes]":
    """Runs git to read the file `name` (REV:path); its returncode is not 0 if there is no such file. Raises
    OutputError if git is not installed or does not answer."""
    git = program("git")
    if git is None:
        raise OutputError("git is not installed", name, hint)
    settings = [word for setting in _SETTINGS for word in ("-c", setting)]
    environ = {key: value for key, value in os.environ.items() if key not in _REMOVED_VARIABLES}
    try:
        return subprocess.run(
            [git, "--no-pager", "--no-replace-objects", *settings, "cat-file", "blob", name],
            env=environ | _ENVIRONMENT,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=_MAX_SECONDS,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise OutputError(f"git gave no answer in {_MAX_SECONDS} s", name, hint) from None
