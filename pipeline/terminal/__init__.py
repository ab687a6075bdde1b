"""What the terminal shows: progress, findings, checks, the closing text.

- check_text: A check as lines of text, in the terminal.
- closing: The closing text of a build: findings, checks that did not pass, API calls and the output folder.
- finding_lines: Diagnostics as lines of text, in the terminal: those of a code together, of which the worst
  are shown.
- output: Output to a terminal or a pipe, without control characters and API keys, and no wider than the
  terminal.
- pasted: Text for the user to paste into a shell: quoted, so that no character of a name runs anything there.
- progress: Shows the progress of a build on the terminal and in `build.log`.
- streams: Standard streams whose reader may close them early: `linkwright --help | head -1`.
- wrapping: Wraps the lines of messages to the width of a terminal.
"""
