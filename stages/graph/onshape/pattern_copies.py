"""Patterns at work: which of their copies get the mates of their seeds, and what holds those seeds."""

from collections.abc import Collection, Iterable
from dataclasses import dataclass, field

from stages.graph.onshape.assembly import Assembly, Occurrence, Path, Pattern
from stages.graph.onshape.pattern_supports import Hanging, Support
from stages.robot.diagnostics import Diagnostics


@dataclass(slots=True)
class Series:
    """A pattern at work. `gone`: copies that are not there or not like their seed; `free`: those
    without mates and groups of their own, which get their seed's. Filled as copies are made: `joints`,
    `served` (copies that got joints) and `carried` (mates of fastened seeds that are not repeated)."""

    pattern: Pattern
    support: Support
    free: frozenset[Path]
    gone: frozenset[Path]
    joints: int = 0
    served: set[Path] = field(default_factory=set)
    carried: set[str] = field(default_factory=set)

    def repeats(self, owner: Path) -> bool:
        """Whether mates and groups of the assembly `owner` act again for the copies."""
        return owner in (self.pattern.owner, self.support.level)


def series_of(
    assembly: Assembly, patterns: Iterable[Pattern], rigid: Collection[Path], log: Diagnostics
) -> dict[Path, list[Series]]:
    """Seed → its patterns; what of them cannot be copied is reported in `log`.

    `rigid`: the sub-assemblies inside which nothing moves.
    """
    hanging = Hanging(assembly)
    found: dict[Path, list[Series]] = {}
    for pattern in patterns:
        seeds, alike, gone = _copies(assembly, pattern, log)
        support = hanging.support(seeds, pattern.owner, rigid) if alike else Support(pattern.owner)
        levels = dict.fromkeys((pattern.owner, support.level))
        free = alike - _held_by_their_own(alike, seeds, levels, hanging)
        series = Series(pattern, support, free, gone)
        for seed in seeds:
            found.setdefault(seed, []).append(series)
        if free and support.above:
            message = (
                f"{support.within} holds the seed inside its sub-assembly and {support.above} from outside: "
                "its copies follow the inner one"
            )
            hint = (
                "FASTEN the seed to what carries it; or pattern what it carries, too; "
                "or make the sub-assembly rigid (depth.rigid)"
            )
            log.report("W-PATTERN-LEVEL", message, pattern.title, hint)
    return found


def _copies(
    assembly: Assembly, pattern: Pattern, log: Diagnostics
) -> tuple[list[Path], frozenset[Path], frozenset[Path]]:
    """The seeds that are there, the copies that are made of the same, and those that are not or are gone."""
    occurrences = assembly.occurrences
    seeds: list[Path] = []
    alike: set[Path] = set()
    gone: set[Path] = set()
    for seed, copies in pattern.copies.items():
        alive = [copy for copy in copies if copy in occurrences]
        gone.update(set(copies) - set(alive))
        if seed in occurrences:
            seeds.append(seed)
        elif alive:
            titles = ", ".join(occurrences[copy].title for copy in alive)
            message = f"the seed of {titles} is suppressed or gone: it has no joints to copy"
            log.report("W-PATTERN", message, pattern.title, "mate the copies themselves")
        for copy in alive if seed in occurrences else ():
            if _source(occurrences[copy]) == _source(occurrences[seed]):
                alike.add(copy)
                continue
            gone.add(copy)
            message = (
                f"{occurrences[copy].title} is not an instance of the same part as its seed: "
                "it is unknown where the seed's mates would hold it"
            )
            log.report("W-PATTERN", message, pattern.title, "mate it itself")
    return seeds, frozenset(alike), frozenset(gone)


def _held_by_their_own(
    copies: frozenset[Path], seeds: Collection[Path], levels: Iterable[Path], hanging: Hanging
) -> set[Path]:
    """The copies that mates and groups of their own hold; one that only carries something is not held."""
    owner, *_ = levels
    others = copies.union(seeds)
    return {
        copy
        for level in levels
        for copy in copies
        if (level, copy) in hanging.touching and hanging.holds(copy, owner, level, others)
    }


def _source(occurrence: Occurrence) -> tuple[object, ...]:
    return tuple(occurrence.record.get(key) for key in ("type", "documentId", "elementId", "partId"))
