"""Writes all files of the format URDF."""

from linkwright.stages.export.urdf.model import write_urdf
from linkwright.stages.export.urdf.section import UrdfFormatSection
from linkwright.stages.export.urdf.srdf import model as srdf
from linkwright.stages.export.writer import Case, FormatFiles, WriterInput


def write(inputs: WriterInput) -> FormatFiles:
    """Returns the files of the format, and the cases by which their losses are found."""
    written = inputs.written
    urdf_path, srdf_path = UrdfFormatSection.paths(written.robot.name)
    plan = srdf.plan_of(written)
    files = {
        urdf_path: write_urdf(written, inputs.keys.export.urdf),
        srdf_path: srdf.write_srdf(written.robot, plan),
    }
    cases = (
        Case("urdf", written, written.as_urdf.robot, urdf_path, None),
        Case("srdf", written, written.robot, srdf_path, plan),
    )
    return FormatFiles(files, cases, record={"srdf": plan.record})
