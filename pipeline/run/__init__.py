"""A run of a build: its stages in order, what it observed, and whether all of it is unchanged.

- build: One build: five stages in order; a stage whose inputs did not change comes from the cache.
- description: `robot.json` of a build that stops before the export.
- early_imports: Imports the modules of later stages in a thread while the fetch stage waits for the network.
- preflight: Checks of a plan before its first stage runs.
- products: The robot's files in the output folder.
- program: The identity of the program that runs: of its own code, and of all that Python may import beside
  it.
- single: One build by the command line: again where nothing changed, else anew.
- state: The state of a running build, from which its report and its documents are made.
- strictness: `validate.level: strict`: a warning is a failure.
- unchanged: Recognises an unchanged build as a whole: nothing is composed, and no stage is asked.
"""
