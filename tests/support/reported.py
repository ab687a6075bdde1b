"""What a robot, or the log of a pass, reports: by code, place and message."""

from linkwright.stages.robot.diagnostics import Diagnostics


def notes(source, code=""):
    """The problems and diagnostics; with `code`, those of this code."""
    noted = (*source.problems, *source.notes) if isinstance(source, Diagnostics) else source.diagnostics
    return [note for note in noted if code in ("", note.code)]


def codes(source):
    return sorted(note.code for note in notes(source))


def reports(source, code=""):
    return [(note.code, note.where) for note in notes(source, code)]


def only(source, code=""):
    """The single note; with `code`, the single note of this code."""
    (note,) = notes(source, code)
    return note
