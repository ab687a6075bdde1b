"""`linkwright new URL|FILE [NAME]`: writes the file of a new robot."""

from collections.abc import Sequence

from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.json_documents.document import CommandDocument

HELP = """\
linkwright new: writes the file of a new robot, to be built and to be edited.

usage: linkwright new [option ...] URL|FILE [NAME] [cache.dir=FOLDER]

  linkwright new "https://cad.onshape.com/documents/.../w/.../e/..." my_arm
                                    an assembly, as the browser shows its
                                    address; keep the quotes
  linkwright new arm.urdf           a URDF, a xacro file (with
                                    source.trust=true), an MJCF, or a bundle
  linkwright new --deep URL         also finds parts without material
  linkwright new --from arm/config.json
                                    an assembly as onshape-to-robot builds it

It writes ./robot/NAME.yaml: the source; the joints that were found, with type
and limits; lines to fill in for what is missing (limits, effort, velocity,
motors); choices, each with its reason: a fixed or free base, legs, a gripper,
actuators; and the problems with which the build ends until they are solved,
with what to do. linkwright robot=NAME builds it as it is. No file is replaced.

Without NAME it is the assembly's name if a cached reply has it, else onshape_
and the beginning of the element's id; that of a file is the file's own.

An assembly costs one API call for its definition, and with --deep another for
each part studio; a build uses these replies again. A file costs none.

options:
  --deep            asks for the masses of all parts, too
  --from FILE       a config.json of onshape-to-robot, or its folder: all its
                    options become keys, or the file says why not; URL is then
                    needed only if FILE has no url
  --config-dir DIR  writes DIR/robot/NAME.yaml
  --json            prints one JSON document
"""

_USAGE = "linkwright new URL|FILE [NAME]; linkwright new --help shows more"
_OPTIONS = {"--config-dir": "config_dir", "-cd": "config_dir", "--from": "peer"}
_FLAGS = ("--deep", "--json")
_CACHE, _TRUST = "cache.dir=", "source.trust="


def run(arguments: Sequence[str]) -> int | CommandDocument:
    """Writes the robot's file and returns the exit status or a document. Raises ConfigError for wrong usage,
    and the errors of `pipeline.new_robot.command.run`."""
    # Late: the help of the verb needs none of it.
    from linkwright.pipeline.new_robot import command

    remaining, places = list(arguments), []
    options = {"config_dir": "", "cache": "", "peer": ""}
    flags = {name for name in _FLAGS if name in remaining}
    trust = False
    while remaining:
        word = remaining.pop(0)
        option, sign, value = word.partition("=")
        if option in _OPTIONS:
            if not sign and not remaining:
                noun = "file" if option == "--from" else "folder"
                raise ConfigError(f"{option} needs a {noun}", "new", _USAGE)
            options[_OPTIONS[option]] = value if sign else remaining.pop(0)
        elif word.startswith(_CACHE):
            options["cache"] = word.removeprefix(_CACHE)
        elif word.startswith(_TRUST):
            trust = word == f"{_TRUST}true"
        elif word.startswith("-") and word not in _FLAGS:
            raise ConfigError(f"there is no option {option}", "new", _USAGE)
        elif word not in _FLAGS:
            places.append(word)
    source, name = _places(places, options["peer"])
    request = command.NewRequest(
        source,
        name,
        peer=options["peer"],
        deep="--deep" in flags,
        trust=trust,
        cache=options["cache"] or None,
        config_dir=options["config_dir"],
        json="--json" in flags,
    )
    return command.run(request)


def _places(places: Sequence[str], peer: str) -> tuple[str, str]:
    """Returns the address or file, and the name; "" for what is left out. With `peer`, a configuration that
    names its source, an argument without "/" is the name."""
    if peer and len(places) < 2:
        text = places[0] if places else ""
        return (text, "") if "/" in text else ("", text)
    if not 1 <= len(places) <= 2:
        msg = f"expected an address or a file, and perhaps a name; got {len(places)} arguments"
        raise ConfigError(msg, "new", _USAGE)
    return places[0], places[1] if len(places) > 1 else ""
