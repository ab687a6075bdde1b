"""`linkwright snapshot [DIR]`: keeps texts about a repository's robots, to compare them later."""

from collections.abc import Sequence
from pathlib import Path

from linkwright.pipeline.errors import ConfigError

HELP = """\
linkwright snapshot: writes a text about each robot of a repository, to be kept
in git. Whoever changes a file then sees which robots it changes.

usage: linkwright snapshot [--check] [--config-dir DIR] [DIR]

  linkwright snapshot               writes snapshots/NAME.txt of each robot in
                                    ./robot/ and experiment in ./experiment/
  linkwright snapshot arms/robot/   the same in arms/, as if run there
  linkwright snapshot --check       writes nothing; shows which keys and figures
                                    changed, and what is missing or left over

A snapshot has the options that were chosen, the keys that differ from the
defaults, with ${...} as written, and figures of the robot (links, joints, mass
...), from a build with until=graph. Nothing uses the network: a robot from
Onshape has figures only if its bundle is beside its snapshot:

  linkwright bundle my_arm snapshots/my_arm.zip

An experiment that chooses no robot is combined with each. Files and folders
whose names begin with _ are parts of robots and have no snapshot. Snapshots of
robots that are gone are removed. pytest --linkwright compares in tests.

options:
  --check           only compares
  --config-dir DIR  robots of DIR/robot/ too; may be repeated
"""

_USAGE = "linkwright snapshot; linkwright snapshot --help shows more"
_FOLDER_HINT = f"it takes a folder; without arguments all robots of ./robot are taken: {_USAGE}"
_CONFIG_DIR = ("--config-dir", "-cd")


def run(arguments: Sequence[str]) -> int:
    """Writes or checks the snapshots and returns the exit status. Raises ConfigError for wrong usage, and if
    there is no robot."""
    # Late: the help of the verb needs none of it.
    from linkwright.pipeline.snapshots import command

    check, folders, place = _parsed(arguments)
    working_folder = Path.cwd()
    folder = working_folder / place
    if not folder.is_dir():
        msg = f"there is no folder {place}" if not folder.exists() else f"{place} is not a folder"
        raise ConfigError(msg, "snapshot", _FOLDER_HINT)
    # The folder robot/ means the folder around it.
    folder = folder.resolve().parent if folder.resolve().name == "robot" else folder
    return command.run(folder, [str(working_folder / name) for name in folders], check)


def _parsed(arguments: Sequence[str]) -> tuple[bool, list[str], str]:
    """Returns whether to check only, the folders of --config-dir, and the folder of the repository."""
    remaining, folders, places, check = list(arguments), [], [], False
    while remaining:
        word = remaining.pop(0)
        option, sign, value = word.partition("=")
        if option in _CONFIG_DIR:
            if not sign and not remaining:
                raise ConfigError(f"{option} needs a folder", "snapshot", _USAGE)
            folders.append(value if sign else remaining.pop(0))
        elif word == "--check":
            check = True
        elif word.startswith("-"):
            raise ConfigError(f"there is no option {word}", "snapshot", _USAGE)
        else:
            places.append(word)
    if len(places) > 1:
        raise ConfigError(f"expected one folder, got {len(places)}", "snapshot", _USAGE)
    return check, folders, places[0] if places else "."
