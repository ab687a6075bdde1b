"""Defines the error of a damaged file."""


class Damaged(ValueError):
    """The error that a file is damaged. Our messages quote nothing of the file; messages of libraries may."""
