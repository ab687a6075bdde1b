"""Finds the copies of each pattern that get the mates of their seeds, and what supports them."""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field

from linkwright.stages.graph.onshape.assembly import Assembly, Path, Pattern
from linkwright.stages.graph.onshape.patterns.mirror_planes import Image, MirrorPlanes
from linkwright.stages.graph.onshape.patterns.supports import Support, SupportSearch
from linkwright.stages.robot.diagnostics import Diagnostics


@dataclass(slots=True)
class Series:
    """A pattern and the state of its copies."""

    pattern: Pattern
    support: Support
    images: Mapping[Path, Image]
    """How each copy comes from its seed, if that is known."""
    free: frozenset[Path]
    """Copies that no mates or groups of their own support: they get those of their seed."""
    rebuilt: frozenset[Path]
    """Sub-assemblies of mirror-image parts without features of their own: they get those inside their
    seeds."""
    joints: int = 0
    """Number of joints that copies got so far."""
    served: set[Path] = field(default_factory=set)
    """Copies that got joints so far."""
    carried: set[str] = field(default_factory=set)
    """Mates of fastened seeds that are not repeated, so far."""

    def counterpart(self, seed: Path, copy: Path, place: Path) -> Path:
        """Returns the occurrence in a copy that is the image of `place`, at or below its seed; () if
        unknown."""
        leaves = self.images[copy].leaves
        return copy + place[len(seed) :] if leaves is None or place == seed else leaves.get(place, ())

    def repeats(self, owner: Path) -> bool:
        """Returns whether mates and groups of the assembly `owner` are repeated for the copies."""
        return owner in (self.pattern.owner, self.support.level)


def series_of(
    assembly: Assembly,
    patterns: Iterable[Pattern],
    rigid: Collection[Path],
    planes: MirrorPlanes,
    log: Diagnostics,
) -> dict[Path, list[Series]]:
    """Maps each seed to its patterns, and reports copies that cannot be made.

    `rigid`: the sub-assemblies without inner motion. `planes`: finds the images of seeds.
    """
    busy = {mate.ref.owner for mate in assembly.mates} | {group.owner for group in assembly.groups}
    search = SupportSearch(assembly)
    by_seed: dict[Path, list[Series]] = {}
    for pattern in patterns:
        seeds = _seeds(assembly, pattern, log)
        images = planes.images(pattern)
        support = search.support(seeds, pattern.owner, rigid) if images else Support(pattern.owner)
        levels = dict.fromkeys((pattern.owner, support.level))
        free = images.keys() - _supported_by_own_mates(images.keys(), seeds, levels, search)
        rebuilt = [copy for copy, image in images.items() if image.leaves and copy not in busy]
        series = Series(pattern, support, images, frozenset(free), frozenset(rebuilt))
        for seed in seeds:
            by_seed.setdefault(seed, []).append(series)
        if free and support.outer_title:
            message = (
                f"{support.inner_title} holds the seed inside its sub-assembly and {support.outer_title} "
                "from outside: its copies use the inner mate"
            )
            hint = (
                "FASTEN the seed to what carries it; or pattern the parts that it carries, too; "
                "or make the sub-assembly rigid (depth.rigid)"
            )
            log.report("W-PATTERN-LEVEL", message, pattern.title, hint)
    return by_seed


def _seeds(assembly: Assembly, pattern: Pattern, log: Diagnostics) -> list[Path]:
    """Returns the seeds of a pattern that are there; reports W-PATTERN for copies whose seed is not."""
    occurrences = assembly.occurrences
    for seed, copies in pattern.copies.items():
        alive = [copy for copy in copies if copy in occurrences]
        if alive and seed not in occurrences:
            titles = ", ".join(occurrences[copy].title for copy in alive)
            message = f"the seed of {titles} is suppressed or deleted: it has no joints to copy"
            log.report("W-PATTERN", message, pattern.title, "mate the copies themselves")
    return [seed for seed in pattern.copies if seed in occurrences]


def _supported_by_own_mates(
    copies: Collection[Path], seeds: Collection[Path], levels: Iterable[Path], search: SupportSearch
) -> set[Path]:
    """Returns the copies that mates and groups of their own support, rather than only connect to something
    carried."""
    owner, *_ = levels
    members = {*copies, *seeds}
    return {
        copy
        for level in levels
        for copy in copies
        if (level, copy) in search.touching and search.holds(copy, owner, level, members)
    }
