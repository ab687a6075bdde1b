"""URDF: the tree of links and joints, in one file, and beside it the SRDF for MoveIt."""

from linkwright.stages.export.urdf.section import UrdfFormatSection
from linkwright.stages.export.writer import Case, FormatFiles, WriterInput


class UrdfWriter:
    """`<name>.urdf` and `<name>.srdf`."""

    section = UrdfFormatSection
    reads: tuple[str, ...] = ()
    modules: tuple[str, ...] = (
        "linkwright.stages.export.urdf.model",
        "linkwright.stages.export.urdf.srdf.model",
    )

    def write(self, given: WriterInput) -> FormatFiles:
        from linkwright.stages.export.urdf.model import write_urdf
        from linkwright.stages.export.urdf.srdf import model as srdf

        written = given.written
        urdf_path, srdf_path = self.section.paths(written.robot.name)
        plan = srdf.plan_of(written)
        files = {
            urdf_path: write_urdf(written, given.keys.export.urdf),
            srdf_path: srdf.write_srdf(written.robot, plan),
        }
        cases = (
            Case("urdf", written, written.as_urdf.robot, urdf_path, None),
            Case("srdf", written, written.robot, srdf_path, plan),
        )
        return FormatFiles(files, cases, record={"srdf": plan.record})
