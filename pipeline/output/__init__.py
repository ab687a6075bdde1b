"""Writes output folders: knows which of their files are linkwright's, and replaces an earlier build.

- access: Gives a new output the mode and the owner of the old output.
- builds: Finds the build that a user names.
- conflicts: Finds files in an output folder that a build must not replace: it keeps them, or they stop it.
- folder: Writes the output folder beside its path, swaps it in by renames, and repairs it after a kill.
- location: Checks that a folder may be an output folder, unlike the home, the working or the cache folder.
- manifest: Reads and writes the manifest of a folder, which tells linkwright's files from others.
- packing: Packs the inputs of a build from the cache into a bundle.
- replacing: Replaces a file as a whole.
- room: Checks before expensive work that the disks have room for a build.
"""
