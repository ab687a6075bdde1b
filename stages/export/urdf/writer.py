"""URDF: the tree of links and joints, in one file, and beside it the SRDF for MoveIt."""

from stages.export.writer import Exported, WriterInput


class UrdfWriter:
    """`<name>.urdf` and `<name>.srdf`."""

    reads: tuple[str, ...] = ()
    modules: tuple[str, ...] = ("stages.export.urdf.model", "stages.export.urdf.srdf.model")

    def paths(self, robot: str) -> tuple[str, ...]:
        return (f"{robot}.urdf", f"{robot}.srdf")

    def write(self, given: WriterInput) -> Exported:
        from stages.export.urdf.model import write_urdf
        from stages.export.urdf.srdf import model as srdf
        from stages.export.urdf.srdf.unsupported import unsupported as not_in_srdf
        from stages.export.urdf.unsupported import unsupported

        urdf_path, srdf_path = self.paths(given.robot.name)
        plan = srdf.plan_of(given.robot, given.geometry, given.actuation, given.form)
        files = {
            urdf_path: write_urdf(given.robot, given.geometry, given.keys.export.urdf, given.form),
            srdf_path: srdf.write_srdf(given.robot, plan),
        }
        losses = unsupported(given.robot, given.geometry, given.form)
        told = (*losses, *not_in_srdf(given.robot, given.geometry, plan))
        return Exported(files, told, record={"srdf": plan.record})


WRITER = UrdfWriter()
