"""USD: the robot, and the meshes that it refers to."""

from linkwright.stages.export.usd.section import UsdFormatSection
from linkwright.stages.export.writer import FormatFiles, WriterInput


class UsdWriter:
    """`<name>.usda`, and `<name>_meshes.usd`, the layer that it refers to."""

    section = UsdFormatSection
    reads: tuple[str, ...] = ()
    modules: tuple[str, ...] = ()

    def write(self, given: WriterInput) -> FormatFiles:
        # Late: the table of writers is read by builds that write nothing.
        from linkwright.stages.export.usd.build import write

        return write(given)
