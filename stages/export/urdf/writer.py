"""URDF: the tree of links and joints, in one file."""

from stages.export.writer import Exported, WriterInput


class UrdfWriter:
    """`<name>.urdf`."""

    reads: tuple[str, ...] = ()
    modules: tuple[str, ...] = ("stages.export.urdf.model",)

    def paths(self, robot: str) -> tuple[str, ...]:
        return (f"{robot}.urdf",)

    def write(self, given: WriterInput) -> Exported:
        from stages.export.urdf.model import write_urdf
        from stages.export.urdf.unsupported import unsupported

        (path,) = self.paths(given.robot.name)
        diagnostics = tuple(unsupported(given.robot, given.geometry, given.form))
        text = write_urdf(given.robot, given.geometry, given.keys.export.urdf, given.form)
        return Exported({path: text}, diagnostics)


WRITER = UrdfWriter()
