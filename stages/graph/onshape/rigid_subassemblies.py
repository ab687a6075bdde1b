"""Finds the rigid sub-assemblies (keys `depth.max`, `depth.rigid` and `depth.flexible`)."""

from collections.abc import Sequence
from fnmatch import fnmatchcase

from linkwright.stages.graph.onshape.assembly import Assembly, Occurrence, Path
from linkwright.stages.graph.section import DepthSection
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.text.globs import no_match_hint, without_number
from linkwright.stages.robot.text.names import legal_name


def rigid_subassemblies(assembly: Assembly, depth: DepthSection, log: Diagnostics) -> frozenset[Path]:
    """Returns the sub-assembly occurrences that are rigid.

    A sub-assembly is rigid if it is deeper than `max` levels, if a glob of `rigid` matches it, if a mirror
    welds it, or if it is in a rigid sub-assembly; never if a glob of `flexible` matches it. A glob without a
    slash is compared with an instance's name (as typed, without its number, and as in robot files), a glob
    with a slash with its whole title. Reports E-GLOB for a glob that matches nothing.
    """
    subs = sorted((o for o in assembly.occurrences.values() if not o.is_part), key=lambda o: o.path)
    rigid, flexible = (
        _matching_subs(subs, globs, where, log)
        for where, globs in (("depth.rigid", depth.rigid), ("depth.flexible", depth.flexible))
    )
    paths: set[Path] = set()
    for path in (sub.path for sub in subs):  # sorted, so that a parent comes before its children
        if path in flexible:
            continue
        too_deep = depth.max is not None and len(path) > depth.max
        if too_deep or path in rigid or path in assembly.stiff or path[:-1] in paths:
            paths.add(path)
    return frozenset(paths)


def _matching_subs(
    subs: Sequence[Occurrence], globs: Sequence[str], where: str, log: Diagnostics
) -> set[Path]:
    matching_paths: set[Path] = set()
    for glob in globs:
        matches = {sub.path for sub in subs if any(fnmatchcase(text, glob) for text in _texts(sub, glob))}
        if not matches:
            hint = no_match_hint(glob, {"sub-assemblies": [sub.title for sub in subs]})
            log.report_unmatched("E-GLOB", f"no sub-assembly matches {glob!r}", where, hint, glob)
        matching_paths |= matches
    return matching_paths


def _texts(sub: Occurrence, glob: str) -> tuple[str, ...]:
    if "/" in glob:
        return (sub.title,)
    name = sub.names[-1]
    return name, without_number(name), legal_name(name)
