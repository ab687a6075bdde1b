"""Reports what a build replaces for its targets (I-TARGET)."""

from collections.abc import Callable, Collection

from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.targets.engines import ENGINES, ShapeLimits


def replacement(change: str, targets: Collection[str], hint: str = "") -> Diagnostic:
    """Returns the diagnostic of a replacement, with the targets that require it."""
    default_hint = f"without {'it' if len(targets) == 1 else 'them'} this stays as it is"
    return Diagnostic("I-TARGET", change, "target", f"for {', '.join(targets)}; {hint or default_hint}")


def targets_limiting(targets: Collection[str], condition: Callable[[ShapeLimits], object]) -> list[str]:
    """Returns the targets whose shape limits fulfil a condition."""
    return [name for name in targets if condition(ENGINES[name].shapes)]
