"""MJCF: the robot, and a scene around it, for MuJoCo."""

from linkwright.stages.export.mjcf.section import MjcfFormatSection
from linkwright.stages.export.writer import Case, FormatFiles, WriterInput


class MjcfWriter:
    """`<name>.xml`, the robot alone, and `scene.xml`, which includes it."""

    section = MjcfFormatSection
    reads: tuple[str, ...] = ()
    modules: tuple[str, ...] = ("linkwright.stages.export.mjcf.model", "linkwright.stages.export.mjcf.scene")

    def write(self, given: WriterInput) -> FormatFiles:
        from linkwright.stages.export.mjcf.contact.filters import filters
        from linkwright.stages.export.mjcf.extras import lost
        from linkwright.stages.export.mjcf.model import write_mjcf
        from linkwright.stages.export.mjcf.reset import reset
        from linkwright.stages.export.mjcf.scene import write_scene

        written = given.written
        model, scene = self.section.paths(written.robot.name)
        kept_apart = filters(written.as_mjcf.robot, written.mjcf_shapes)
        text = write_mjcf(given, kept_apart)
        files = {model: text, scene: write_scene(given, text)}
        case = Case("mjcf", written, written.robot, model, kept_apart)
        return FormatFiles(files, (case,), (*lost(written), *reset(written)))
