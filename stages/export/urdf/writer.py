"""URDF: the tree of links and joints, in one file, and beside it the SRDF for MoveIt."""

from linkwright.stages.export.writer import FormatFiles, WriterInput


class UrdfWriter:
    """`<name>.urdf` and `<name>.srdf`."""

    reads: tuple[str, ...] = ()
    modules: tuple[str, ...] = (
        "linkwright.stages.export.urdf.model",
        "linkwright.stages.export.urdf.srdf.model",
    )

    def paths(self, robot: str) -> tuple[str, ...]:
        return (f"{robot}.urdf", f"{robot}.srdf")

    def write(self, given: WriterInput) -> FormatFiles:
        from linkwright.stages.export.urdf.model import write_urdf
        from linkwright.stages.export.urdf.srdf import model as srdf
        from linkwright.stages.export.urdf.srdf.unsupported import unsupported as not_in_srdf
        from linkwright.stages.export.urdf.unsupported import unsupported

        written = given.written
        urdf_path, srdf_path = self.paths(written.robot.name)
        plan = srdf.plan_of(written)
        files = {
            urdf_path: write_urdf(written, given.keys.export.urdf),
            srdf_path: srdf.write_srdf(written.robot, plan),
        }
        told = (*unsupported(written), *not_in_srdf(written.robot, written.shapes, plan))
        return FormatFiles(files, told, record={"srdf": plan.record})


WRITER = UrdfWriter()
