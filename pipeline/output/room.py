"""Checks before expensive work that the disks have room for a build."""

import contextlib

from linkwright.pipeline.caching.disk_space import MIN_FREE_BYTES
from linkwright.pipeline.caching.store import Store
from linkwright.pipeline.output.folder import Output


def require_room(store: Store, output: Output | None, suffix: str) -> None:
    """Raises CacheError or OutputError if a disk lacks the space for a build as large as the last build."""
    size = max(MIN_FREE_BYTES, output.size(), output.size(suffix)) if output else MIN_FREE_BYTES
    # Both together, since they may be on one disk.
    with store.room(size), output.room(size) if output else contextlib.nullcontext():
        pass
