"""The verbs of the command besides building: one module for each verb.

Each has `HELP` (text) and `run(arguments) -> exit status`, and raises the errors of `pipeline.errors`:
ConfigError for wrong usage (exit status 2), other errors for failures (1).
"""

VERBS = {
    "bundle": "linkwright.pipeline.verbs.bundle",
    "cache": "linkwright.pipeline.verbs.cache",
    "check": "linkwright.pipeline.verbs.check",
    "diff": "linkwright.pipeline.verbs.diff",
    "explain": "linkwright.pipeline.verbs.explain",
    "view": "linkwright.pipeline.verbs.view",
}
"""Verb → the module with its `HELP` and its `run(arguments) -> exit status`."""
