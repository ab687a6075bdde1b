"""Numbers with their nouns."""


def count(number: int, one: str, many: str = "") -> str:
    """A number with its noun: "1 link", "2 links"."""
    return f"{number} {one if number == 1 else many or one + 's'}"
