"""Reads and writes a bundle as a zip file."""
