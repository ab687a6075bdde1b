"""The copies of each pattern: which of them get the mates of their seeds, and how those are supported."""

from collections.abc import Collection, Iterable
from dataclasses import dataclass, field

from stages.graph.onshape.assembly import Assembly, Occurrence, Path, Pattern
from stages.graph.onshape.pattern_supports import Support, SupportSearch
from stages.robot.diagnostics import Diagnostics


@dataclass(slots=True)
class Series:
    """One pattern and the state of its copies. `gone`: copies that are missing or differ from their seed;
    `free`: copies that no mates or groups of their own support, which get those of their seed. Filled as
    copies are made: `joints`, `served` (copies that got joints) and `carried` (mates of fastened seeds
    that are not repeated)."""

    pattern: Pattern
    support: Support
    free: frozenset[Path]
    gone: frozenset[Path]
    joints: int = 0
    served: set[Path] = field(default_factory=set)
    carried: set[str] = field(default_factory=set)

    def repeats(self, owner: Path) -> bool:
        """Whether mates and groups of the assembly `owner` are repeated for the copies."""
        return owner in (self.pattern.owner, self.support.level)


def series_of(
    assembly: Assembly, patterns: Iterable[Pattern], rigid: Collection[Path], log: Diagnostics
) -> dict[Path, list[Series]]:
    """Seed → its patterns; copies that cannot be made are reported in `log`.

    `rigid`: the sub-assemblies without inner motion.
    """
    search = SupportSearch(assembly)
    found: dict[Path, list[Series]] = {}
    for pattern in patterns:
        seeds, alike, gone = _copies(assembly, pattern, log)
        support = search.support(seeds, pattern.owner, rigid) if alike else Support(pattern.owner)
        levels = dict.fromkeys((pattern.owner, support.level))
        free = alike - _supported_by_own_mates(alike, seeds, levels, search)
        series = Series(pattern, support, free, gone)
        for seed in seeds:
            found.setdefault(seed, []).append(series)
        if free and support.above:
            message = (
                f"{support.within} holds the seed inside its sub-assembly and {support.above} from outside: "
                "its copies use the inner mate"
            )
            hint = (
                "FASTEN the seed to what carries it; or pattern the parts that it carries, too; "
                "or make the sub-assembly rigid (depth.rigid)"
            )
            log.report("W-PATTERN-LEVEL", message, pattern.title, hint)
    return found


def _copies(
    assembly: Assembly, pattern: Pattern, log: Diagnostics
) -> tuple[list[Path], frozenset[Path], frozenset[Path]]:
    """The existing seeds, the copies of the same part, and the copies that differ or are missing."""
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
            message = f"the seed of {titles} is suppressed or deleted: it has no joints to copy"
            log.report("W-PATTERN", message, pattern.title, "mate the copies themselves")
        for copy in alive if seed in occurrences else ():
            if _source(occurrences[copy]) == _source(occurrences[seed]):
                alike.add(copy)
                continue
            gone.add(copy)
            message = (
                f"{occurrences[copy].title} is not an instance of the same part as its seed: "
                "the seed's mates cannot be copied to it"
            )
            log.report("W-PATTERN", message, pattern.title, "mate the copy itself")
    return seeds, frozenset(alike), frozenset(gone)


def _supported_by_own_mates(
    copies: frozenset[Path], seeds: Collection[Path], levels: Iterable[Path], search: SupportSearch
) -> set[Path]:
    """The copies that mates and groups of their own support, rather than only carry something on them."""
    owner, *_ = levels
    others = copies.union(seeds)
    return {
        copy
        for level in levels
        for copy in copies
        if (level, copy) in search.touching and search.holds(copy, owner, level, others)
    }


def _source(occurrence: Occurrence) -> tuple[object, ...]:
    return tuple(occurrence.record.get(key) for key in ("type", "documentId", "elementId", "partId"))
