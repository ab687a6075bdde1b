"""Defines the document of `linkwright bundle`."""

from dataclasses import dataclass
from typing import ClassVar

from linkwright.pipeline.json_documents.document import CommandDocument


@dataclass(frozen=True)
class BundleDocument(CommandDocument):
    """A bundle: the inputs of a build in a file (`linkwright bundle`).

    exit_status: 0.
    file: the bundle.
    folder: the output folder of the build.
    replies: the number of replies or files in the bundle.
    size: the size of the bundle [bytes].
    command: the command that builds from it, for a shell.
    """

    FORMAT: ClassVar[str] = "linkwright-bundle"

    exit_status: int
    file: str
    folder: str
    replies: int
    size: int
    command: str
