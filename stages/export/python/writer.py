"""A Python package: the files of the other formats, as pip installs them."""

from linkwright.stages.export.python.section import PythonFormatSection
from linkwright.stages.export.writer import FormatFiles, WriterInput


class PythonWriter:
    """`python/`."""

    section = PythonFormatSection
    reads: tuple[str, ...] = ("urdf", "mjcf")
    modules: tuple[str, ...] = ("linkwright.stages.export.python.package",)

    def write(self, given: WriterInput) -> FormatFiles:
        # Late: the table of writers is read by builds that write nothing.
        from linkwright.stages.export.python.build import write

        return write(given)
