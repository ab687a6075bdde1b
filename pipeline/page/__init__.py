"""Pages for people: `report.html` of a build.

Each section is a function that prepares values, and a template in `html/templates/` that shows them.

- changed: Renders the changes since the previous build in the folder.
- checks: Renders the checks of a build: those that failed, those that warn, and those that passed, folded.
- codes: Renders the meanings of the codes on a page, and links each code to its meaning.
- colliders: Renders the colliders: how near each is to its part, totals, and pictures.
- contacts: Renders the pairs of links that do not collide.
- document: Renders report.html: a single file that shows a build and needs nothing else.
- figures: Names the figures of a build for people.
- files: Renders the files of a build, with sizes and digests, and the values that vary in its variants.
- findings: Renders the diagnostics of a build, and the error that ended it, as HTML.
- fix_first: Renders the gravest problems of a build, to be fixed first, in a few lines.
- graph: Renders the kinematic graph: its picture, its outline as text, and its tables.
- head: Renders the head of a build's page: what was built, how it went, its size, and the files.
- live_view: Inserts the live view at the top of a page.
- order: Renders the order of joints, actuators and sensors in the files, that of a policy's vectors.
- provenance: Renders the origin of a build, and its cost: source, versions, stages, API calls, figures.
- readers: Renders which content of the robot's files other readers drop.
"""
