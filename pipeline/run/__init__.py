"""Runs a build: its stages in order, or nothing if the whole build is unchanged.

- build: Runs a single build: five stages in order, with the cached result of each unchanged stage.
- description: Writes `robot.json` of a build that stops before the export.
- early_imports: Imports the modules of later stages in a thread while the fetch stage waits for the network.
- preflight: Checks a plan before its first stage runs.
- products: Collects the robot's files for the output folder.
- program: Identifies the running program: its own code, and everything else that Python may import.
- single: Runs a build from the command line, or reuses its result if nothing changed.
- state: Keeps the state of a running build, and makes its report and its documents.
- strictness: Makes warnings failures for `validate.level: strict`.
- unchanged: Recognises an unchanged build as a whole, without composing it or asking its stages.
"""
