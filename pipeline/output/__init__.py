"""The output folder: whose files are in it, and how a build replaces an earlier build.

- access: Who may use an output: its mode and its owner, which what replaces it keeps.
- builds: Finds the build that a user names.
- conflicts: Files in an output folder that a build must not replace: it keeps them, or they stop the build.
- folder: The output folder: written beside its path, swapped in by renames, repaired after a kill.
- location: Checks that a folder may be an output folder: not the home, the working or the cache folder, say.
- manifest: The manifest of a folder: which files in it are linkwright's.
- room: The room that a build needs on its disks, looked for before expensive work.
"""
