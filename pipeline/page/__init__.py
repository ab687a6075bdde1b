"""Pages for people: `report.html` of a build.

Each section is a function that prepares values, and a template in `html/templates/` that shows them.

- changed: What changed since the previous build of the folder, for people.
- checks: The checks of a build: those that failed, those that warn, and those that passed, folded.
- codes: What the codes on a page mean, to which each of them leads.
- colliders: The part of report.html about colliders: how near each is to its part, totals, and pictures.
- contacts: The pairs of links that do not collide, for people.
- document: report.html: a build for people, one file that needs nothing else.
- figures: What the figures of a build are called for people.
- files: The files of a build, with sizes and digests.
- findings: The diagnostics of a build, and what ended it.
- fix_first: What to fix first: the gravest of all that a build found, in a few lines.
- graph: The kinematic graph: its picture, its outline as text, and the tables that the graph stage made of
  it.
- head: The head of a build's page: what was built, how it went, its size, and the files.
- hero: The robot at the top of its page: the live view, else its picture.
- order: The order of joints, actuators and sensors in the files, for people: the vectors of a policy.
- provenance: Where a build comes from, and what it took: source, versions, stages, API calls, figures.
- readers: What other readers drop of the robot's files, for people.
"""
