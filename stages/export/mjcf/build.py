"""Writes all files of the format, from what the other modules of this room make of the robot."""

from linkwright.stages.export.mjcf.contact.filters import filters
from linkwright.stages.export.mjcf.extras import lost
from linkwright.stages.export.mjcf.model import write_mjcf
from linkwright.stages.export.mjcf.reset import reset
from linkwright.stages.export.mjcf.scene import write_scene
from linkwright.stages.export.mjcf.section import MjcfFormatSection
from linkwright.stages.export.writer import Case, FormatFiles, WriterInput


def write(given: WriterInput) -> FormatFiles:
    """The files of the format, with what they lose of the robot."""
    written = given.written
    model, scene = MjcfFormatSection.paths(written.robot.name)
    kept_apart = filters(written.as_mjcf.robot, written.mjcf_shapes)
    text = write_mjcf(given, kept_apart)
    files = {model: text, scene: write_scene(given, text)}
    case = Case("mjcf", written, written.robot, model, kept_apart)
    return FormatFiles(files, (case,), (*lost(written), *reset(written)))
