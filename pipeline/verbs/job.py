"""`linkwright job FILE N`: runs a job of a list, or a share of them."""

from collections.abc import Sequence

from linkwright.pipeline.sweep import list_commands

HELP = """\
linkwright job: run jobs of a list.

usage: linkwright job FILE N [-q]
       linkwright job FILE --shard K/N [-q]

  linkwright job jobs.json 3        run job 3; the first job is job 0
  linkwright job jobs.json --shard 3/8
                                    run every eighth job from the third on, one
                                    after the other

A job may run anywhere: it needs the list, the files of the robot beside it, and
for an Onshape document the cache into which `linkwright jobs FILE --fetch` has
fetched. It needs no API key and makes no call. A job that is done already is an
unchanged build. A list holds command lines: run only lists that you trust.
With -q only errors are shown.

exit status, as of a build (for a share that of its worst job): 0 built and
valid; 3 a check failed; 1 failed; 2 wrong usage, no list, or a list that is
stale
"""


def run(arguments: Sequence[str]) -> int:
    """Runs the verb and returns the exit status; raises ConfigError for wrong usage or an invalid list."""
    return list_commands.job(arguments)
