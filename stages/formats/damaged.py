"""A file of a format that is damaged."""


class Damaged(ValueError):
    """What is wrong with a file, in words that quote nothing of it; those of libraries may."""
