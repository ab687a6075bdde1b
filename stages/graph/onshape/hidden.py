"""Without what is hidden in CAD: as if it were suppressed."""

from dataclasses import replace

from stages.graph.onshape.assembly import Assembly, Path, check_parts, leave_out_empty
from stages.robot.diagnostics import Diagnostics

TOLD = 10
"""So many hidden instances are told by name."""


def without_hidden(assembly: Assembly, log: Diagnostics) -> Assembly:
    """The assembly without its hidden instances, all below them, and the features that name one.

    AssemblyError where no part is left.
    """
    hidden = sorted((o for o in assembly.occurrences.values() if o.hidden), key=lambda o: o.path)
    gone = {occurrence.path for occurrence in hidden}
    if not gone:
        return assembly

    def stays(path: Path) -> bool:
        return not any(path[:depth] in gone for depth in range(1, len(path) + 1))

    left = replace(assembly, occurrences={p: o for p, o in assembly.occurrences.items() if stays(p)})
    leave_out_empty(left)
    present = {(), *left.occurrences}
    left.mates = [mate for mate in assembly.mates if all(entity.path in present for entity in mate.entities)]
    left.relations = [relation for relation in assembly.relations if relation.owner in present]
    left.groups = [
        replace(group, members=tuple(member for member in group.members if member in present))
        for group in assembly.groups
    ]
    left.connectors = [connector for connector in assembly.connectors if connector.entity.path in present]
    left.patterns = [pattern for pattern in assembly.patterns if pattern.owner in present]
    check_parts(left, "show a part of it, or say hidden: keep")
    titles = [o.title for o in hidden if stays(o.path[:-1])]
    more = [f"{len(titles) - TOLD} more"] if len(titles) > TOLD else []
    mates = len(assembly.mates) - len(left.mates)
    log.report(
        "I-HIDDEN",
        f"{len(titles)} hidden instance(s) left out, and {mates} mate(s) on them (hidden: drop): "
        + ", ".join(titles[:TOLD] + more),
    )
    return left
