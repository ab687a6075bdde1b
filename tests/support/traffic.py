"""Faults at some of the calls of a local Onshape, what was asked of it, and a document to ask about."""

from collections import Counter

from tests.fake_onshape import solids
from tests.fake_onshape.document import Document
from tests.fake_onshape.frames import frame


def at_path(fault, *words):
    """A fault hook: the fault replaces each reply whose target holds all these words."""
    return lambda method, target, number: fault if all(word in target for word in words) else None


def at_call(fault, *numbers):
    """A fault hook: the fault replaces the replies to the calls of these numbers, from 0."""
    return lambda method, target, number: fault if number in numbers else None


def asked_kinds(server):
    """How often each kind of request was made, by the last piece of its path."""
    pieces = [target.partition("?")[0].rsplit("/", 2) for _, target, _ in server.calls]
    return dict(Counter("definition" if kind == "e" else last for _, kind, last in pieces))


def targets_of(server, *words):
    """The targets of all calls that hold all these words."""
    return [target for _, target, _ in server.calls if all(word in target for word in words)]


def rack(used=2, unused=0, studios=1):
    """An assembly that uses some parts of part studios that hold more."""
    document = Document("Rack")
    boxes = [document.studio(f"Boxes {number}") for number in range(studios)]
    whole = document.assembly("Rack")
    for far, studio in enumerate(boxes):
        for number in range(used + unused):
            block = solids.box(0.01 + 0.001 * number, 0.02, 0.03 + 0.001 * far)
            part = studio.part(f"Box {far} {number}", block, density=1000)
            if number < used:
                whole.add(part, fixed=True, pose=frame((number, far, 0)))
    return document
