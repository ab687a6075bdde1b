"""Sets how often Python collects garbage in a process that builds."""

import gc


def collect_rarely() -> None:
    """Makes collections rare. Nearly all objects live until a build ends, and by default collections would
    take a tenth of its time."""
    gc.set_threshold(100_000, 50, 100)


def freeze_present_objects() -> None:
    """Excludes all present objects, such as modules, from later collections. A second call does nothing."""
    if not gc.get_freeze_count():
        gc.collect()
        gc.freeze()
