"""Faults that are planted in the text of a file: what a pattern finds is replaced."""

import random
import re
from dataclasses import dataclass

from tests.support.mutations.kind import Files, Kinds, NothingToChange, Plant, Planted


@dataclass(frozen=True)
class Fault:
    """In the file of this pattern of paths: the group `old` of one of the places that match becomes `new`. A
    finding names `element`, which may have other groups in braces, and `attribute`."""

    name: str
    file: str
    pattern: str
    new: str
    element: str
    attribute: str = ""


def plants(fault: Fault) -> Plant:
    def plant(files: Files, rng: random.Random) -> Planted:
        path = rng.choice(sorted(files.folder.glob(fault.file)) or [files.folder])
        places = list(re.finditer(fault.pattern, path.read_text(encoding="utf-8"))) if path.is_file() else []
        if not places:
            raise NothingToChange
        place = rng.choice(places)
        (start, end), text = place.span("old"), place.string
        path.write_text(text[:start] + fault.new + text[end:], encoding="utf-8")
        return Planted(fault.element.format(**place.groupdict()), (fault.attribute,))

    return plant


def kinds(file: str, code: str, *faults: Fault) -> Kinds:
    """A kind of each fault, which the check of this code names."""
    made = Kinds(file)
    for fault in faults:
        made.add(fault.name, code)(plants(fault))
    return made
