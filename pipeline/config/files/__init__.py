"""Checks the files of a configuration: their content, and the folders and hosts that they name."""
