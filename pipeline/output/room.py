"""The room that a build needs on its disks, looked for before expensive work."""

import contextlib

from linkwright.pipeline.caching.disk_space import LEAST
from linkwright.pipeline.caching.store import Store
from linkwright.pipeline.output.folder import Output


def require_room(store: Store, output: Output | None, suffix: str) -> None:
    """CacheError or OutputError where a disk lacks the space for a build as large as the last build."""
    size = max(LEAST, output.size(), output.size(suffix)) if output else LEAST
    # Both together, since they may be on one disk.
    with store.room(size), output.room(size) if output else contextlib.nullcontext():
        pass
