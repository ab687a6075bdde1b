"""`linkwright job FILE N`: runs a job of a list, or a share of them."""

from collections.abc import Sequence

from linkwright.pipeline.json_documents.document import CommandDocument
from linkwright.pipeline.sweep import list_commands

HELP = """\
linkwright job: run jobs of a list.

usage: linkwright job FILE N [-q] [--json]
       linkwright job FILE --shard K/N [-q] [--json]

  linkwright job jobs.json 3        run job 3; the first job is job 0
  linkwright job jobs.json --shard 3/8
                                    run every eighth job from the third on, one
                                    after the other

A job may run anywhere: it needs the list, the files of the robot beside it, and
for an Onshape document the cache into which `linkwright jobs FILE --fetch` has
fetched. It needs no API key and makes no call. A job that is done already is an
unchanged build. A list holds command lines: run only lists that you trust.
With -q only errors are shown; with --json one JSON document is printed.
"""


def run(arguments: Sequence[str]) -> int | CommandDocument:
    """Runs the verb; returns the exit status or a document. Raises ConfigError for wrong usage or an invalid
    list."""
    return list_commands.job(arguments)
