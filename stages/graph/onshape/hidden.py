"""Leaves out instances that are hidden in CAD, as if they were suppressed (key `hidden`)."""

from dataclasses import replace

from linkwright.stages.graph.onshape.assembly import Assembly, Path, check_parts, without_empty
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.text.plural import count

MAX_LISTED = 10
"""Largest number of hidden instances that are listed by name."""


def without_hidden(assembly: Assembly, log: Diagnostics) -> Assembly:
    """Returns the assembly without its hidden instances, all below them, and the features that name any of
    them. Reports I-HIDDEN.
    Raises AssemblyError if no part is left.
    """
    hidden_occurrences = sorted((o for o in assembly.occurrences.values() if o.hidden), key=lambda o: o.path)
    hidden_paths = {occurrence.path for occurrence in hidden_occurrences}
    if not hidden_paths:
        return assembly

    def stays(path: Path) -> bool:
        return not any(path[:depth] in hidden_paths for depth in range(1, len(path) + 1))

    occurrences = without_empty({p: o for p, o in assembly.occurrences.items() if stays(p)})
    remaining_paths = {(), *occurrences}
    visible = replace(
        assembly,
        occurrences=occurrences,
        mates=[
            mate for mate in assembly.mates if all(side.path in remaining_paths for side in mate.entities)
        ],
        relations=[relation for relation in assembly.relations if relation.owner in remaining_paths],
        groups=[
            replace(group, members=tuple(member for member in group.members if member in remaining_paths))
            for group in assembly.groups
        ],
        connectors=[
            connector for connector in assembly.connectors if connector.entity.path in remaining_paths
        ],
        patterns=[pattern for pattern in assembly.patterns if pattern.owner in remaining_paths],
    )
    check_parts(visible, "show a part of it, or set hidden: keep")
    titles = [o.title for o in hidden_occurrences if stays(o.path[:-1])]
    remainder = [f"{len(titles) - MAX_LISTED} more"] if len(titles) > MAX_LISTED else []
    mates = len(assembly.mates) - len(visible.mates)
    log.report(
        "I-HIDDEN",
        f"{count(len(titles), 'hidden instance')} left out, and {count(mates, 'mate')} on them "
        "(hidden: drop): " + ", ".join(titles[:MAX_LISTED] + remainder),
    )
    return visible
