"""Reads files of any content, within limits of size, and finds where in them an error is."""
