"""Finds the copies of patterns that get the mates of their seeds, and the supports of the seeds."""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field

from linkwright.stages.graph.onshape.assembly import Assembly, Path, Pattern
from linkwright.stages.graph.onshape.patterns.mirror_planes import Image, MirrorPlanes
from linkwright.stages.graph.onshape.patterns.supports import Support, SupportSearch
from linkwright.stages.robot.diagnostics import Diagnostics


@dataclass(slots=True)
class CopySeries:
    """The copies of a pattern, and the joints made for them so far."""

    pattern: Pattern
    support: Support
    """The support of the seeds."""
    images: Mapping[Path, Image]
    """Copy → its relation to its seed; copies whose relation is unknown are left out."""
    unsupported_copies: frozenset[Path]
    """Copies without supporting mates and groups of their own: they get the mates and groups of their
    seeds."""
    bare_mirror_copies: frozenset[Path]
    """Copies that are sub-assemblies of mirror-image parts, without mates and groups of their own: they get
    the mates and groups inside their seeds."""
    joint_count: int = 0
    """Number of joints of the copies."""
    copies_with_joints: set[Path] = field(default_factory=set)
    """Copies that have any of these joints."""
    carrying_mate_titles: set[str] = field(default_factory=set)
    """Titles of mates by which a fastened seed carries something: they are not repeated for the copies."""

    def counterpart(self, seed: Path, copy: Path, occurrence: Path) -> Path:
        """Returns the occurrence in `copy` that is the image of `occurrence`, which is at or below `seed`; ()
        if it is unknown."""
        leaves = self.images[copy].leaves
        if leaves is None or occurrence == seed:
            return copy + occurrence[len(seed) :]
        return leaves.get(occurrence, ())

    def repeats_features_of(self, owner: Path) -> bool:
        """Tells whether mates and groups of the assembly `owner` are repeated for the copies."""
        return owner in (self.pattern.owner, self.support.assembly)


def copy_series_by_seed(
    assembly: Assembly,
    patterns: Iterable[Pattern],
    rigid_assemblies: Collection[Path],
    planes: MirrorPlanes,
    log: Diagnostics,
) -> dict[Path, list[CopySeries]]:
    """Returns the series of copies of each seed. Reports W-PATTERN for copies whose seed does not exist,
    W-PATTERN-LEVEL if mates of two assemblies hold a seed, and what `planes` reports.

    `rigid_assemblies`: the sub-assemblies without inner motion. `planes`: finds the images of seeds.
    """
    # Assemblies with mates or groups (`supports.Feature`) of their own.
    owners_with_features = {mate.ref.owner for mate in assembly.mates}
    owners_with_features |= {group.owner for group in assembly.groups}
    search = SupportSearch(assembly)
    series_by_seed: dict[Path, list[CopySeries]] = {}
    for pattern in patterns:
        seeds = _seeds(assembly, pattern, log)
        images = planes.images(pattern)
        # Without images, nothing is copied.
        support = search.support(seeds, pattern.owner, rigid_assemblies) if images else Support(pattern.owner)
        supported_copies = _supported_copies(pattern.owner, support.assembly, images.keys(), seeds, search)
        unsupported_copies = frozenset(images.keys() - supported_copies)
        # Only copies that consist of other parts than their seeds have leaves: mirror-image parts.
        bare_mirror_copies = frozenset(
            copy for copy, image in images.items() if image.leaves and copy not in owners_with_features
        )
        series = CopySeries(pattern, support, images, unsupported_copies, bare_mirror_copies)
        for seed in seeds:
            series_by_seed.setdefault(seed, []).append(series)
        if unsupported_copies and support.outer_title:
            _report_two_levels(pattern, support, log)
    return series_by_seed


def _report_two_levels(pattern: Pattern, support: Support, log: Diagnostics) -> None:
    """Reports W-PATTERN-LEVEL: mates of two assemblies hold the seed."""
    message = (
        f"{support.inner_title} holds the seed inside its sub-assembly and {support.outer_title} from "
        "outside: the copies use the mate inside"
    )
    hint = (
        "in the sub-assembly, FASTEN the seed to the part that carries it; or pattern the parts that the "
        "seed carries, too; or mate the copies themselves; or make the sub-assembly rigid (depth.rigid)"
    )
    log.report("W-PATTERN-LEVEL", message, pattern.title, hint)


def _seeds(assembly: Assembly, pattern: Pattern, log: Diagnostics) -> list[Path]:
    """Returns the seeds of a pattern that exist; reports W-PATTERN for copies whose seed does not."""
    occurrences = assembly.occurrences
    for seed, copies in pattern.copies.items():
        existing_copies = [copy for copy in copies if copy in occurrences]
        if existing_copies and seed not in occurrences:
            titles = ", ".join(occurrences[copy].title for copy in existing_copies)
            message = f"the seed of {titles} is suppressed or deleted: it has no joints to copy"
            log.report("W-PATTERN", message, pattern.title, "mate the copies themselves")
    return [seed for seed in pattern.copies if seed in occurrences]


def _supported_copies(
    owner: Path,
    support_assembly: Path,
    copies: Collection[Path],
    seeds: Collection[Path],
    search: SupportSearch,
) -> set[Path]:
    """Returns the copies that mates or groups of their own support. Mates that only join a copy to something
    that it carries do not support it.

    `owner`: the pattern's assembly; `support_assembly`: `Support.assembly`, the assembly whose mates and
    groups support the seeds.
    """
    members = {*copies, *seeds}
    supported_copies = set()
    for assembly_path in {owner, support_assembly}:
        for copy in copies:
            if (assembly_path, copy) not in search.features_by_instance:
                continue
            if search.is_supported(copy, owner, assembly_path, members):
                supported_copies.add(copy)
    return supported_copies
