"""Writes numbers with their nouns."""


def count(number: int, noun: str, many: str = "") -> str:
    """Returns a number with its noun: "1 link", "2 links". `many`: the plural, if it is not the noun with
    "s"."""
    return f"{number} {noun if number == 1 else many or noun + 's'}"
