"""How a build runs: composing, caching, reporting. Knows no robotics.

- cli: The command `linkwright`: arguments, help, exit status, error border.
- completion: Tab completion for bash, zsh and fish: the shell scripts, and the candidates for a command line.
- digest: Digests of contents.
- documents: The documents about a build: report.json, report.html, config.yaml and build.log.
- element_files: The files with XML that `elements` names: read before a build, since what they hold decides
  its result.
- errors: Errors on the command line: each is one message and an exit status.
- help_text: The texts of `--help`, a screen, and `--help-all`, within 80 columns.
- interrupt: Ctrl-C ends a command with exit status 130, wherever it comes.
- key_path: The place of a value in the configuration, and its full key as users type it.
- lock: A lock file: one owner at a time, among all threads and processes that use the same file.
- mesh_details: What the report tells of a robot's geometry, and what the terminal shows meanwhile.
- motor_files: Where the files of the motor library are.
- observed: What a build asks of the file system and of the environment before its first stage, with each
  answer.
- options: Parses the command line into options and overrides.
- report: The report of a build: `Report`, and its JSON.
- secrets: Secrets that must never be written: the API keys, in any encoding.
"""
