"""`linkwright skill`: prints the instructions for agents that use Linkwright."""

from collections.abc import Sequence

from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.reference import SKILL
from linkwright.pipeline.terminal.output import say

HELP = """\
linkwright skill: the instructions for agents that use Linkwright.

usage: linkwright skill [--path]

  linkwright skill                  print the text
  linkwright skill --path           print the path of the file, SKILL.md in a
                                    folder of its own, which can be copied to
                                    where an agent keeps its skills

The text says when to use Linkwright, names ten commands, how to read what they
print with --json, how to mend the likeliest findings, and what not to do.
"""


def run(arguments: Sequence[str]) -> int:
    """Prints the text or its path, and returns the exit status. Raises ConfigError for wrong usage."""
    if list(arguments) not in ([], ["--path"]):
        msg = f"expected nothing or --path, got {' '.join(arguments)}"
        raise ConfigError(msg, "skill", "linkwright skill; linkwright skill --help shows more")
    if arguments:
        print(SKILL)  # in one line, also on a narrow terminal
    else:
        say(SKILL.read_text(encoding="utf-8").rstrip("\n"))
    return 0
