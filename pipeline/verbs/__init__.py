"""Holds the verbs of the command besides building, in a module for each verb.

Each module has `HELP` (text, to which the command adds the exit status) and `run(arguments)`, which returns
the exit status, or with `--json` a document. It raises the errors of `pipeline.errors`: ConfigError for
wrong usage (exit status 2), other errors for failures (1). `pipeline.reference.exit_status` has the statuses
of all.

- bundle: Packs the inputs of a build into one file.
- cache: Shows, cleans and checks the cache.
- check: Checks whether the files of a robot are right.
- diff: Shows the differences between two robots.
- doctor: Checks whether builds can work on this computer.
- explain: Explains a key or the code of a message.
- job: Runs a job of a list, or a share of them.
- jobs: Shows the outcome of the jobs of a list; fetches their sources.
- launcher_lines: Describes the launchers of sweeps, and their keys, for `linkwright explain`.
- motor_lines: Describes a motor and its values in lines of text.
- new: Writes the file of a new robot.
- skill: Prints the instructions for agents that use Linkwright.
- snapshot: Keeps texts about a repository's robots, to compare them later.
- view: Opens the robot of a build in MuJoCo's own viewer.
"""

VERBS = {
    "bundle": "linkwright.pipeline.verbs.bundle",
    "cache": "linkwright.pipeline.verbs.cache",
    "check": "linkwright.pipeline.verbs.check",
    "diff": "linkwright.pipeline.verbs.diff",
    "doctor": "linkwright.pipeline.verbs.doctor",
    "explain": "linkwright.pipeline.verbs.explain",
    "job": "linkwright.pipeline.verbs.job",
    "jobs": "linkwright.pipeline.verbs.jobs",
    "new": "linkwright.pipeline.verbs.new",
    "skill": "linkwright.pipeline.verbs.skill",
    "snapshot": "linkwright.pipeline.verbs.snapshot",
    "view": "linkwright.pipeline.verbs.view",
}
"""Verb → the module with its `HELP` and its `run(arguments)`."""
