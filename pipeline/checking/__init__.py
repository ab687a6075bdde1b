"""Checks of files that are there already: which are made, and how their results are told."""
