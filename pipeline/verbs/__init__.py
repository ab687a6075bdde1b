"""What the command does besides building: one module a verb, named in `pipeline.cli.VERBS`.

Each has `HELP` (text) and `run(arguments) -> exit status`, and raises the errors of `pipeline.errors`:
ConfigError for wrong usage (exit status 2), any other for what fails (1).
"""
