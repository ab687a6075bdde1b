"""Sets how often Python collects garbage in a process that builds."""

import gc


def collect_rarely() -> None:
    """Makes collections rare: nearly all objects live until a build ends, and the garbage collector would
    take a tenth of its time."""
    gc.set_threshold(100_000, 50, 100)


def freeze_present_objects() -> None:
    """Excludes everything in memory now, such as all modules, from later collections. Called once
    in a process."""
    if not gc.get_freeze_count():
        gc.collect()
        gc.freeze()
