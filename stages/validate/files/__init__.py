"""Checks of the text of model files: what a reader of XML sees before any engine runs.

`CHECKS` names the modules, in the order of the report. Each has a `CODE`, the `NAME` of its check, what it
says where that `PASSED`, and a function `findings` of a document (`stages.validate.reading.documents`); and a
function `level`, where not all that it finds is an error.
"""

CHECKS = ("known", "names", "numbers", "references", "assets", "paths")
"""Modules of this room."""
