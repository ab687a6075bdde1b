"""Chooses the share by which each quantity varies: from the configuration, or from the origin of its value.

The less certain the origin of a value, the wider it varies; `docs/guide/variants.md` has the reasons.
"""

from collections.abc import Mapping, Sequence

from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.text.globs import matching_indices, no_match_hint

CONFIG_KEY = "variants.ranges"
"""The key of the configuration that has the globs."""

SHARE_BY_ORIGIN: Mapping[str, float] = {
    "measured": 0.05,
    "identified": 0.1,
    "datasheet": 0.2,
    "source": 0.1,
    "given": 0.1,
    "estimated": 0.3,
    "unset": 0.5,
}
"""Origin of a value → the share of it by which it varies to both sides. measured: on the motor; identified:
fitted to recordings; datasheet: of the motor's maker; source: CAD or the file; given: by the configuration;
estimated: by Linkwright; unset: MuJoCo's default."""


def shares_of(
    origins: Mapping[str, str], ranges: Mapping[str, float | str], log: Diagnostics
) -> dict[str, float]:
    """Returns the share of each quantity that a glob matches; of several globs, the last counts. `origins`:
    quantity → origin of its value; `ranges`: glob → share, or "auto" for the share in
    `SHARE_BY_ORIGIN`."""
    shares: dict[str, float] = {}
    for glob, names in quantities_by_glob(ranges, list(origins), log).items():
        share = ranges[glob]
        shares |= {
            name: SHARE_BY_ORIGIN[origins[name]] if isinstance(share, str) else share for name in names
        }
    return shares


def quantities_by_glob(
    ranges: Mapping[str, float | str], quantities: Sequence[str], log: Diagnostics
) -> dict[str, list[str]]:
    """Returns the quantities that each glob matches. Reports a glob without any match (E-GLOB)."""
    names = [{name} for name in quantities]
    matches = {glob: [quantities[number] for number in matching_indices(glob, names)] for glob in ranges}
    for glob, matched_quantities in matches.items():
        if matched_quantities:
            continue
        hint = no_match_hint(glob, {"quantities": quantities})
        log.report_unmatched("E-GLOB", f"no quantity matches {glob!r}", CONFIG_KEY, hint, glob)
    return matches
