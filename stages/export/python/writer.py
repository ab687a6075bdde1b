"""Registers the writer of the Python package, with the files of the other formats for pip."""

from linkwright.stages.export.python.section import PythonFormatSection
from linkwright.stages.export.writer import FormatFiles, WriterInput


class PythonWriter:
    """Writes the files in `python/`."""

    section = PythonFormatSection
    reads: tuple[str, ...] = ("urdf", "mjcf")
    modules: tuple[str, ...] = ("linkwright.stages.export.python.package",)

    def write(self, inputs: WriterInput) -> FormatFiles:
        # Imported late: builds that write nothing also read the table of writers.
        from linkwright.stages.export.python.build import write

        return write(inputs)
