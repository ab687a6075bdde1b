"""`linkwright jobs FILE`: shows the outcome of the jobs of a list; `--fetch` fetches their sources."""

from collections.abc import Sequence

from linkwright.pipeline.json_documents.document import CommandDocument
from linkwright.pipeline.sweep import list_commands

HELP = """\
linkwright jobs: the jobs of a sweep, listed in a file for any scheduler.

usage: linkwright jobs FILE [--fetch | --shard K/N] [-q] [--json]

  linkwright -m robot=my_arm root=fixed,free --plan jobs.json
                                    write the list of jobs; build nothing
  linkwright jobs jobs.json --fetch
                                    fetch their sources: once, with the API key
  linkwright job jobs.json 3        run job 3, anywhere, without a key
  linkwright jobs jobs.json         which are done, running, failed, stale or
                                    missing; writes their summary

A job is stale where its folder has the build of another configuration, or of
another state of the document. This command looks only at the folders: whether
the files of a robot have changed since the list was written is noticed by
`linkwright job` and --fetch, which then refuse the list. Relative paths start
at the folder in which the list was written, which is found from the place of
the list: a tree of files that holds both may be copied to other computers.

options:
  --fetch           fetch each configuration of an Onshape document into the
                    cache, at the state that the list names
  --shard K/N       only every Nth job, from the Kth on: 1/8 to 8/8; writes
                    no summary
  -q, --quiet       show only errors, and the jobs where not all are built and
                    valid
  --json            prints one JSON document
"""


def run(arguments: Sequence[str]) -> int | CommandDocument:
    """Runs the verb; returns the exit status or a document. Raises ConfigError for wrong usage or an invalid
    list."""
    return list_commands.jobs(arguments)
