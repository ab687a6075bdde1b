"""What is different between two robots, as their robot.json describe them.

- change: One difference between two robots.
- compare: Compares two robots, table by table of robot.json.
- git: Reads a file of a revision from git, which runs nothing that the repository's own configuration names.
- pairs: Which thing of one robot is which of another: by name, and where CAD has it under another name by
  that.
- read: Reads the robot.json of an output folder, of a file, or of a revision in git.
- show: Differences of two robots as text, as JSON for programs, and as Markdown for a pull request.
- since: What a build changes about the robot that the last build left in the same folder.
- values: Values of robot.json: whether two are alike, and what is said of two that are not.
"""
