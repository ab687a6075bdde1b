"""Runs builds: composing, caching, reporting. Knows no robotics.

- cli: Runs the command `linkwright`: arguments, help, exit status, error border.
- completion: Completes command lines in bash, zsh and fish: the shell scripts, and the candidates.
- digest: Computes digests of contents.
- documents: Collects the documents about a build: report.json, report.html, config.yaml and build.log.
- element_files: Reads the XML files that the key `elements` names, before a build: their content is part of
  its input.
- errors: Turns errors into a message and an exit status.
- help_text: Holds the texts of `--help`, a screen, and `--help-all`, within 80 columns.
- interrupt: Ends a command with exit status 130 after Ctrl-C, wherever it comes.
- key_path: Converts the path of a value in the configuration to the full key that users type.
- lock: Locks by a lock file: one owner at a time, among all threads and processes that use the same file.
- mesh_details: Writes the report's tables about a robot's geometry, and shows the progress of the mesh stage.
- motor_files: Finds the files of the motor library.
- observed: Records the questions that a build asks the file system and the environment before its first
  stage, with answers.
- options: Parses the command line into options and overrides.
- report: Defines the report of a build, and writes its JSON.
- secrets: Finds and blanks secrets that must never be written: the API keys, in any encoding.
"""
