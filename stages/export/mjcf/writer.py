"""MJCF: the robot, and a scene around it, for MuJoCo."""

from stages.export.writer import Exported, WriterInput


class MjcfWriter:
    """`<name>.xml`, the robot alone, and `scene.xml`, which includes it."""

    reads: tuple[str, ...] = ()
    modules: tuple[str, ...] = ("stages.export.mjcf.model", "stages.export.mjcf.scene")

    def paths(self, robot: str) -> tuple[str, ...]:
        return (f"{robot}.xml", "scene.xml")

    def write(self, given: WriterInput) -> Exported:
        from stages.export.mjcf.extras import lost
        from stages.export.mjcf.form import filters_of
        from stages.export.mjcf.model import write_mjcf
        from stages.export.mjcf.reset import reset
        from stages.export.mjcf.scene import write_scene
        from stages.export.mjcf.unsupported import unsupported

        model, scene = self.paths(given.robot.name)
        kept_apart = filters_of(given.robot, given.geometry, given.mjcf_form)
        written = write_mjcf(given, kept_apart)
        files = {model: written, scene: write_scene(given, written)}
        found = (
            *unsupported(given.robot, given.start, kept_apart.wide, given.mjcf_form),
            *lost(given.robot, given.geometry, given.mjcf_form.extras),
            *reset(given.robot, given.start, given.actuation),
        )
        return Exported(files, found)


WRITER = MjcfWriter()
