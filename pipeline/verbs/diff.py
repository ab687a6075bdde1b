"""`linkwright diff A B`: shows the differences between two robots."""

from collections.abc import Sequence

from linkwright.pipeline.changes import show
from linkwright.pipeline.changes.compare import compare
from linkwright.pipeline.changes.read import read_robot
from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.json_documents.document import CommandDocument
from linkwright.pipeline.reference.exit_status import BUILT, UNMET
from linkwright.pipeline.terminal.output import say

HELP = """\
linkwright diff: shows the differences between two robots.

usage: linkwright diff [--json|--markdown] A B

  linkwright diff outputs/arm outputs/arm_v2
                                    two output folders
  linkwright diff old.json outputs/arm
                                    a robot.json that was kept, and a build
  linkwright diff HEAD:robots/arm robots/arm
                                    the folder in a commit of git, and the
                                    folder as it is now
  linkwright diff --markdown main:robots/arm robots/arm
                                    tables for the text of a pull request

A and B are output folders, robot.json files, or REV:path of git, where path
starts at the folder of the repository or here. Compared are links (mass, center
of mass, inertia), CAD parts, joints (pose, axis, limits, dynamics), loops,
relations, frames, actuators, sensors, and the order of the arrays in each file:
all of robot.json except the origin of its values. A thing that CAD has under
another name is shown as renamed. Numbers count as equal within 1e-9 of the
largest number of their vector.

options:
  --json            for programs, with the values before and after
  --markdown        for a pull request
"""

_USAGE = "linkwright diff A B; linkwright diff --help shows more"
_FORMS = ("--json", "--markdown")


def run(arguments: Sequence[str]) -> int | CommandDocument:
    """Prints the differences and returns the exit status, or returns their document. Raises ConfigError for
    wrong usage, and OutputError if a robot cannot be read."""
    options = [argument for argument in arguments if argument.startswith("-")]
    places = [argument for argument in arguments if not argument.startswith("-")]
    unknown = [option for option in options if option not in _FORMS]
    if unknown:
        msg = f"there is no option {unknown[0]}"
        raise ConfigError(msg, "diff", _USAGE)
    if len(set(options)) > 1:
        msg = f"{' and '.join(sorted(set(options)))} exclude each other"
        raise ConfigError(msg, "diff", _USAGE)
    if len(places) != 2:
        msg = f"expected two robots, got {len(places)}"
        raise ConfigError(msg, "diff", _USAGE)

    before, after = map(read_robot, places)
    changes = compare(before.robot, after.robot)
    if "--json" in options:
        return show.as_document(before, after, changes)
    if options:
        print(show.as_markdown(before, after, changes))
    else:
        say(show.as_text(before, after, changes))
    return UNMET if changes else BUILT
