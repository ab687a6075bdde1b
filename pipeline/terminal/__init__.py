"""Writes to the terminal: progress, findings, checks, the closing text.

- check_text: Writes a check as lines of text.
- closing: Prints the closing text of a build: diagnostics, failed checks, API calls and the output folder.
- display: Chooses the display of a build's progress.
- error_border: Prints the error that ended a command as one message.
- finding_lines: Writes diagnostics as lines of text, grouped by code, the worst of each code first.
- json_output: Prints the document of a command with `--json`: nothing else comes to the standard output.
- output: Writes to a terminal or a pipe, without control characters and API keys, and no wider than the
  terminal.
- pasted: Quotes text for the user to paste into a shell, so that no character of a name runs a command.
- progress: Shows the progress of a build on the terminal and in `build.log`.
- spinner: Shows the progress of a build on a terminal, by Rich.
- streams: Makes standard streams survive a reader that closes them early: `linkwright --help | head -1`.
- suggested: Suggests what to type in place of a command line that cannot be read.
- wrapping: Wraps the lines of messages to the width of a terminal.
"""
