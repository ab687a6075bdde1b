"""`linkwright doctor`: checks whether builds can work on this computer, and tells how to repair them."""

import os
from collections.abc import Mapping, Sequence

from linkwright.pipeline.caching.actions import folder
from linkwright.pipeline.doctor import access, examination, installation, places
from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.json_documents.document import CommandDocument
from linkwright.pipeline.reference.exit_status import BUILT, FAILED
from linkwright.pipeline.terminal.output import say

HELP = """\
linkwright doctor: whether builds can work on this computer, and what to do
where not.

usage: linkwright doctor [--online] [--json] [cache.dir=FOLDER] [source.url=URL]

  linkwright doctor                 looks here, and asks nobody
  linkwright doctor --online        asks Onshape too, by one API call, which
                                    counts: does it answer, may the key read?

Looked at are Python, the packages and extras, MuJoCo, the settings of the
network, the API key (never shown), the folders that builds write to, their free
space, and the display. Each line is ok, a note (something optional is missing)
or wrong, with what to do about it.

options:
  --online    asks cad.onshape.com, or the host of source.url
  --json      prints one JSON document
"""

_USAGE = "linkwright doctor; linkwright doctor --help shows more"
_OPTIONS = ("--online", "--json")
_KEYS = ("cache.dir", "source.url")


def run(arguments: Sequence[str], environ: Mapping[str, str] = os.environ) -> int | CommandDocument:
    """Prints the rows and returns the exit status, or returns their document. Raises ConfigError for wrong
    usage."""
    keys = dict(_key(argument) for argument in arguments if argument not in _OPTIONS)
    cache = folder(keys.get("cache.dir"), environ)
    rows = [
        *installation.examine(),
        *access.examine(environ, cache, keys.get("source.url", ""), online="--online" in arguments),
        *places.examine(environ, cache),
    ]
    if "--json" in arguments:
        return examination.as_document(rows)
    say(examination.as_text(rows))
    return FAILED if any(row.state == "wrong" for row in rows) else BUILT


def _key(argument: str) -> tuple[str, str]:
    name, sign, value = argument.partition("=")
    if name not in _KEYS or not sign or not value:
        noun = "option" if argument.startswith("-") else "argument"
        raise ConfigError(f"there is no {noun} {argument}", "doctor", _USAGE)
    return name, value
