"""Reports what a build replaces for its targets (I-TARGET)."""

from collections.abc import Callable, Collection

from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.targets.engines import ENGINES, ShapeLimits


def replacement_diagnostic(change: str, targets: Collection[str], hint: str = "") -> Diagnostic:
    """Returns I-TARGET for a replacement.

    `change`: the replacement in words, such as "4 meshes in STL → OBJ"; `targets`: the targets that require
    it; `hint`: the text after the targets' names; by default it says that without these targets nothing
    is replaced.
    """
    default_hint = f"without {'it' if len(targets) == 1 else 'them'} this stays as it is"
    return Diagnostic("I-TARGET", change, "target", f"for {', '.join(targets)}; {hint or default_hint}")


def targets_where(targets: Collection[str], condition: Callable[[ShapeLimits], object]) -> list[str]:
    """Returns the targets for whose shape limits the condition is true."""
    return [name for name in targets if condition(ENGINES[name].shapes)]
