"""The output folder: whose files are in it, and how a build replaces an earlier build."""
