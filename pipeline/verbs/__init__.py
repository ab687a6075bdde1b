"""The verbs of the command besides building: one module for each verb.

Each has `HELP` (text) and `run(arguments) -> exit status`, and raises the errors of `pipeline.errors`:
ConfigError for wrong usage (exit status 2), other errors for failures (1).
"""

VERBS = {
    "bundle": "pipeline.verbs.bundle",
    "cache": "pipeline.verbs.cache",
    "check": "pipeline.verbs.check",
    "diff": "pipeline.verbs.diff",
    "explain": "pipeline.verbs.explain",
    "view": "pipeline.verbs.view",
}
"""Verb → the module with its `HELP` and its `run(arguments) -> exit status`."""
