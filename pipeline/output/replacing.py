"""Replaces a file as a whole."""

import contextlib
import secrets
from pathlib import Path

from linkwright.pipeline.caching.shared import with_retries


def replace(file: Path, data: bytes) -> None:
    """Writes a file so that readers see its old or its new content, however many hosts write it at once.

    A kill may leave a hidden file beside it, whose name ends in `.tmp`.
    """
    # Random, since hosts may have the same name, and processes on them the same number.
    temporary = file.with_name(f".{file.name.lstrip('.')}.{secrets.token_hex(4)}.tmp")

    def write() -> None:
        temporary.write_bytes(data)
        temporary.replace(file)

    try:
        with_retries(write)
    except BaseException:
        with contextlib.suppress(OSError):
            temporary.unlink(missing_ok=True)
        raise
