"""Compares two robots by their robot.json.

- build_changes: Compares a build with the previous build in the same folder.
- change: Describes a difference between two robots.
- compare: Compares two robots, table by table of robot.json.
- git: Reads a file of a revision from git, without running programs that the repository's configuration
  names.
- pairs: Pairs the rows of two robots: by name, or by CAD if a row was renamed.
- read: Reads the robot.json of an output folder, of a file, or of a revision in git.
- show: Shows the differences of two robots as text, as a JSON document, and as Markdown for a pull request.
- values: Compares values of robot.json, and describes their difference in words.
"""
