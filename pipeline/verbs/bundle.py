"""`linkwright bundle NAME OUT.zip`: packs the inputs of a build into one file."""

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.json_documents.bundle import BundleDocument
from linkwright.pipeline.json_documents.document import CommandDocument
from linkwright.pipeline.options import JSON
from linkwright.pipeline.terminal import pasted
from linkwright.pipeline.terminal.output import say
from linkwright.stages.robot.text.plural import count

HELP = """\
linkwright bundle: pack the inputs of a build into one file, to build the robot
anywhere.

usage: linkwright bundle NAME OUT.zip [--json] [cache.dir=FOLDER]

  linkwright bundle my_arm my_arm.zip
                                    the inputs of the build in outputs/my_arm
  linkwright bundle builds/arm.failed arm.zip
                                    the folder of any build, also of a failed
                                    build

NAME is the robot's name, or the output folder of its build. The replies come
from the cache, so no API call is made. It is the cache that the build used (key
cache.dir, environment LINKWRIGHT_CACHE, or the platform's folder), unless
cache.dir= names another. OUT.zip is replaced if it is a bundle. With --json one
JSON document is printed.

The zip holds the replies of the CAD system, unchanged; for a URDF its text
(after xacro) and the triangles of its meshes; for an MJCF the model that MuJoCo
compiled. It holds no API key and nothing about this computer. On any computer,
the same configuration builds the same robot files from it:

  linkwright robot=my_arm source=bundle source.path=my_arm.zip
"""

_USAGE = "linkwright bundle NAME OUT.zip; linkwright bundle --help shows more"
_CACHE_KEY = "cache.dir="


@dataclass(frozen=True, slots=True)
class Request:
    """The arguments: the build, the file to write, the cache folder if it is given, and whether to return a
    document."""

    name: str
    out: Path
    cache: str | None
    json: bool = False


def run(arguments: Sequence[str], environ: Mapping[str, str] = os.environ) -> int | CommandDocument:
    """Packs the bundle and returns the exit status or a document.

    Raises ConfigError for wrong usage or an unknown build; raises CacheError if the cache no longer has the
    inputs of the build; raises OutputError if the build read nothing or the file cannot be written; raises
    SecretFound if the inputs hold an API key.
    """
    # Late: the help of the verb needs none of it.
    from linkwright.pipeline.output import packing

    request = parse(arguments)
    folder, data, replies = packing.pack_build(request.name, request.out, request.cache, environ)
    packing.write(request.out, data)
    command = f"linkwright source=bundle {pasted.override('source.path', str(request.out))}"
    if request.json:
        return BundleDocument(0, str(request.out), str(folder), replies, len(data), command)
    size = f"{count(replies, 'reply', 'replies')}, {len(data) / 1e6:.2f} MB"
    say(f"{request.out}: {size}: all inputs of {folder}")
    say(f"  → {command}")
    return 0


def parse(arguments: Sequence[str]) -> Request:
    """Parses the arguments; raises ConfigError for missing or unknown arguments."""
    places = [argument for argument in arguments if not argument.startswith((_CACHE_KEY, "-"))]
    options = [argument for argument in arguments if argument.startswith("-") and argument != JSON]
    caches = [text.removeprefix(_CACHE_KEY) for text in arguments if text.startswith(_CACHE_KEY)]
    if options:
        msg = f"there is no option {options[0]}"
        raise ConfigError(msg, "bundle", _USAGE)
    if len(places) != 2:
        msg = f"expected a build and the file to write, got {count(len(places), 'argument')}"
        raise ConfigError(msg, "bundle", _USAGE)
    if caches and not caches[-1]:
        msg = "expected a folder"
        raise ConfigError(msg, "cache.dir", _USAGE)
    return Request(places[0], Path(places[1]), caches[-1] if caches else None, JSON in arguments)
