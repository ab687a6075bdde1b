"""Reads a file of a revision from git, which runs nothing that the repository's own configuration names.

A repository may come from anywhere, and its configuration can name programs: hooks, filters, text converters,
pagers, helpers of remotes. `cat-file` starts only the helper of a remote from which git fetches missing files
(git-config(1), `remote.<name>.promisor`), and no protocol is allowed here.
"""

import os
import subprocess

from linkwright.pipeline.errors import OutputError
from linkwright.stages.robot.system.programs import program

_LIMIT_S = 60

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
_NOT_GIVEN = (
    "GIT_EXTERNAL_DIFF",
    "GIT_SSH",
    "GIT_SSH_COMMAND",
    "GIT_ASKPASS",
    "GIT_PROXY_COMMAND",
    "GIT_PAGER",
)


def blob(name: str, hint: str) -> "subprocess.CompletedProcess[bytes]":
    """The file that git calls `name` (REV:path); a status other than 0 where it has none. OutputError without
    git, and where it gives no answer."""
    git = program("git")
    if git is None:
        raise OutputError("git is not installed", name, hint)
    settings = [word for setting in _SETTINGS for word in ("-c", setting)]
    environ = {key: value for key, value in os.environ.items() if key not in _NOT_GIVEN}
    try:
        return subprocess.run(
            [git, "--no-pager", "--no-replace-objects", *settings, "cat-file", "blob", name],
            env=environ | _ENVIRONMENT,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=_LIMIT_S,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise OutputError(f"git gave no answer in {_LIMIT_S} s", name, hint) from None
