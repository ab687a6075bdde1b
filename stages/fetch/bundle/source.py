"""Defines the source `bundle`: the replies or files of an earlier fetch in one zip."""

from __future__ import annotations

from collections.abc import Mapping
from hashlib import sha256
from pathlib import Path
from typing import Any, ClassVar

from linkwright.stages.fetch import source_class
from linkwright.stages.fetch.recording import MAX_BYTES
from linkwright.stages.fetch.source import FetchContext, Fetched, FileSource
from linkwright.stages.robot.errors import SourceError
from linkwright.stages.robot.system import regular_files


class BundleSource(FileSource):
    """A source that is a zip file made by `linkwright bundle`."""

    description: ClassVar[str] = "a bundle is a zip file"
    example: ClassVar[str] = "robots/arm.zip"

    advice: ClassVar[str] = "check source.path and its permissions"
    """The hint for a file that cannot be read."""

    def pinned(self, environ: Mapping[str, str]) -> dict[str, Any]:
        return {"kind": "recording", "sha256": sha256(self.content()).hexdigest()}

    def fetch(self, context: FetchContext) -> Fetched:
        # Late: an unchanged source is not read again.
        from linkwright.stages.fetch.bundle.archive import read

        recording = read(self.content(), self.label())
        return Fetched(source_class(recording.kind).replay(recording, self.label()))

    def content(self) -> bytes:
        """Returns the bytes of the zip. Raises SourceError if it cannot be read."""
        try:
            return self.read()
        except regular_files.FileTooLarge as error:
            msg = f"not readable as a bundle: it has {error.size} bytes; at most {MAX_BYTES} are read"
            hint = "check that source.path names the right file"
            raise SourceError(msg, self.label(), hint) from None
        except OSError as error:
            msg = f"it cannot be read: {error.strerror or type(error).__name__}"
            raise SourceError(msg, self.label(), self.advice) from error

    def read(self) -> bytes:
        """Returns the bytes of the zip. Raises the system's errors."""
        return regular_files.content(Path(self._keys.path), MAX_BYTES)
