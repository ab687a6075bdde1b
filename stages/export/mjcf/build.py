"""Writes the MJCF and its scene."""

from linkwright.stages.export.mjcf.contact.filters import filters_of
from linkwright.stages.export.mjcf.extras import report_lost
from linkwright.stages.export.mjcf.model import write_mjcf
from linkwright.stages.export.mjcf.reset import report_reset
from linkwright.stages.export.mjcf.scene import write_scene
from linkwright.stages.export.mjcf.section import MjcfFormatSection
from linkwright.stages.export.writer import Case, FormatFiles, WriterInput


def write(inputs: WriterInput) -> FormatFiles:
    """Returns the MJCF and its scene, with the diagnostics of what they lose."""
    written = inputs.written
    model, scene = MjcfFormatSection.paths(written.robot.name)
    contact_filters = filters_of(written.as_mjcf.robot, written.mjcf_shapes)
    text = write_mjcf(inputs, contact_filters)
    files = {model: text, scene: write_scene(inputs, text)}
    case = Case("mjcf", written, written.robot, model, contact_filters)
    return FormatFiles(files, (case,), (*report_lost(written), *report_reset(written)))
