"""Finds the mass properties of each part: CAD's, overridden by the user's, or estimated from its shape.

Onshape gives each value as [nominal, min, max]; `inertia` is 27 numbers of which the first nine are the
nominal tensor, row by row, about the centroid, in the part studio's axes, with true signs. A composite part
has its own entry; the entries of its constituents are used only if these are in the assembly themselves. A
sheet has no mass, unless the user gives it a mass.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import orjson

from linkwright.stages.graph.globs import entries_of
from linkwright.stages.graph.mass_section import MassSection, PartMassSection
from linkwright.stages.graph.onshape.assembly import Assembly, Occurrence, Path
from linkwright.stages.graph.onshape.mass.mass_estimate import PartShape, shapes_of
from linkwright.stages.graph.onshape.reply_fields import number, numbers, protocol_errors
from linkwright.stages.robot.bundle import ElementKey, OnshapeBundle
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.dynamics.inertia import ZERO, scaled, tensor
from linkwright.stages.robot.model.robot import Inertial, frozen
from linkwright.stages.robot.text.globs import exact_glob, name_list, without_number
from linkwright.stages.robot.text.plural import count

PartKey = tuple[ElementKey, str]
"""A part studio and the id of a part in it."""


class PartMass(NamedTuple):
    """An inertial in the part's frame, the volume [m³], and whether the mass is an estimate."""

    inertial: Inertial
    volume: float
    estimated: bool = False


SHEET = "sheet"
"""The type of a body that is a surface."""

PART_TYPES = ("solid", "composite", SHEET)
"""Types of bodies that can be part of a robot."""

MAX_SMALL_SHARE, MAX_SMALL_TOTAL = 0.01, 0.1
"""Largest shares of the robot's volume: of a small part, and of all small parts together."""

NO_TRIANGLES = "it has a mass, but no inertia, and no triangles to compute it from"
"""The message about a part of estimated mass in a bundle without triangles."""

_MASS_HINT = "give them a material in Onshape, or a mass in mass.parts"

PLAUSIBLE_DENSITIES = (5.0, 23000.0)
"""The range of plausible densities [kg/m³]: foam is no lighter and osmium no heavier."""


@dataclass(frozen=True, slots=True, eq=False)
class PartKind:
    """Occurrences of a part with the same overrides."""

    key: PartKey
    type: str
    overrides: PartMassSection
    occurrences: tuple[Occurrence, ...]
    part_mass: PartMass | None
    """The mass properties in CAD; None if no reply has them."""
    shape: PartShape | None = None

    @property
    def title(self) -> str:
        """The first of the titles of its occurrences."""
        return min(occurrence.title for occurrence in self.occurrences)

    @property
    def label(self) -> str:
        """Its title, and the number of its other occurrences."""
        copies = len(self.occurrences) - 1
        return f"{self.title} (and {copies} more like it)" if copies else self.title

    @property
    def volume(self) -> float:
        """The volume [m³] in CAD, else of its triangles; 0 if neither is known."""
        cad_volume = self.part_mass.volume if self.part_mass else 0.0
        return cad_volume or (self.shape.volume if self.shape else 0.0)

    @property
    def mass(self) -> float | None:
        """Its known mass [kg]: the user's value, else CAD's."""
        if self.overrides.mass is not None:
            return self.overrides.mass
        if self.overrides.density is not None:
            return self.overrides.density * self.volume or None
        return (self.part_mass.inertial.mass or None) if self.part_mass else None


def part_masses(
    assembly: Assembly, bundle: OnshapeBundle, keys: MassSection, log: Diagnostics
) -> dict[Path, PartMass]:
    """Returns the mass properties of every part occurrence; problems are reported once for each kind of part.

    Reports E-BODY-TYPE, E-GLOB and E-MASS; W-BODY-TYPE for a sheet that weighs nothing, W-MASS-ESTIMATED,
    W-MASS-IGNORED, W-DENSITY. A part with a problem gets mass 0.
    """
    kinds = _kinds(assembly, read_masses(bundle), keys.parts, log)
    # Triangles are read only for parts without a mass in CAD.
    unknown = [kind for kind in kinds if not (kind.part_mass and kind.part_mass.inertial.mass > 0)]
    volumes = {kind.key: None if kind.type == SHEET else kind.volume for kind in unknown}
    shapes = shapes_of(bundle, volumes.items())
    kinds = [replace(kind, shape=shapes.get(kind.key)) for kind in kinds]
    estimates = _estimated_masses(kinds, keys, log)
    masses_by_path: dict[Path, PartMass] = {}
    for kind in kinds:
        mass = estimates.get(kind.key, 0.0) if kind.mass is None else kind.mass
        is_estimated = kind.key in estimates and kind.mass is None
        part_mass = PartMass(_inertial(kind, mass, log), kind.volume, is_estimated)
        if kind.mass is not None:
            _check_density(kind, log)
        masses_by_path.update((occurrence.path, part_mass) for occurrence in kind.occurrences)
    return masses_by_path


def _kinds(
    assembly: Assembly,
    masses: Mapping[PartKey, PartMass],
    sections: Mapping[str, PartMassSection],
    log: Diagnostics,
) -> list[PartKind]:
    """Returns the kinds of parts, sorted by title; reports E-BODY-TYPE for those that no robot can have."""
    parts = assembly.parts
    names = [{part.title, part.names[-1], without_number(part.names[-1])} for part in parts]
    groups: dict[tuple[PartKey, tuple[int, ...]], list[Occurrence]] = {}
    for part, entries in zip(parts, entries_of(names, sections, "mass.parts", "part", log), strict=True):
        groups.setdefault((part_key(part.record), entries), []).append(part)
    overrides = list(sections.values())
    kinds = [
        PartKind(
            key=key,
            type=assembly.body_types.get(key, "solid"),
            overrides=_merged_overrides([overrides[index] for index in entries]),
            occurrences=tuple(occurrences),
            part_mass=masses.get(key),
        )
        for (key, entries), occurrences in groups.items()
    ]
    for kind in kinds:
        if kind.type not in PART_TYPES:
            log.report("E-BODY-TYPE", f"a {kind.type} body is not supported", kind.title, "suppress it")
    return sorted(kinds, key=lambda kind: kind.title)


def _merged_overrides(entries: Sequence[PartMassSection]) -> PartMassSection:
    """Returns the entries merged value by value: the later entry wins, and a mass replaces a density and vice
    versa."""
    values: dict[str, object] = {}
    for entry in entries:
        set_values = {name: value for name, value in entry if value is not None}
        if "mass" in set_values or "density" in set_values:
            values = {name: value for name, value in values.items() if name not in ("mass", "density")}
        values.update(set_values)
    return PartMassSection.model_validate(values)


def _estimated_masses(kinds: Sequence[PartKind], keys: MassSection, log: Diagnostics) -> dict[PartKey, float]:
    """Returns masses [kg] of the kinds that have none, by `mass.missing`; reports the treatment of each."""
    missing = [kind for kind in kinds if kind.mass is None and kind.type in PART_TYPES]
    sheets = [kind for kind in missing if kind.type == SHEET and not kind.overrides.density]
    missing = [kind for kind in missing if kind not in sheets]
    for kind in sheets:
        text = "a sheet without mass is only visual: it has no mass and no collider"
        hint = "thicken it, or give it a mass override, in Onshape, or a mass in mass.parts"
        log.report("W-BODY-TYPE", text, kind.title, hint)
    if keys.missing == "ignore":
        _report_ignored(missing, log)
        return {}
    small = _negligible_kinds(kinds, missing) if keys.missing == "auto" else missing
    estimated = [kind for kind in small if kind.volume > 0 and keys.missing != "error"]
    _report_missing([kind for kind in missing if kind not in estimated], kinds, keys, log)
    masses = {kind.key: keys.density * kind.volume for kind in estimated}
    _report_estimated(estimated, masses, keys.density, log)
    return masses


def _report_estimated(
    estimated: Sequence[PartKind], masses: Mapping[PartKey, float], density: float, log: Diagnostics
) -> None:
    """Reports W-MASS-ESTIMATED for the kinds whose mass is estimated with this density [kg/m³]."""
    if not estimated:
        return
    total = sum(masses[kind.key] * len(kind.occurrences) for kind in estimated)
    parts = count(sum(len(kind.occurrences) for kind in estimated), "part")
    text = f"{parts} without mass treated as solid with {density:g} kg/m³: {total:.3g} kg"
    log.report("W-MASS-ESTIMATED", text, name_list(kind.label for kind in estimated), _MASS_HINT)


def _negligible_kinds(kinds: Sequence[PartKind], missing: Sequence[PartKind]) -> list[PartKind]:
    """Returns the negligible parts without mass: each is small, and so is their sum."""
    total = sum(kind.volume * len(kind.occurrences) for kind in kinds)
    small = [kind for kind in missing if kind.volume < MAX_SMALL_SHARE * total]
    together = sum(kind.volume * len(kind.occurrences) for kind in small)
    return small if together < MAX_SMALL_TOTAL * total else []


def _report_ignored(missing: Sequence[PartKind], log: Diagnostics) -> None:
    if missing:
        parts = count(sum(len(kind.occurrences) for kind in missing), "part")
        text = f"{parts} without mass: treated as massless"
        log.report("W-MASS-IGNORED", text, name_list(kind.label for kind in missing), _MASS_HINT)


def _report_missing(
    missing: Sequence[PartKind], kinds: Sequence[PartKind], keys: MassSection, log: Diagnostics
) -> None:
    """Reports E-MASS for each kind; the last report has the lines of YAML for all of them."""
    for kind in missing:
        text = "the part has no mass" if kind.part_mass else "the mass reply does not know this part"
        text += "" if len(kind.occurrences) == 1 else f" ({len(kind.occurrences)} of them)"
        hint = "give it a material, or a mass override, in Onshape"
        if not kind.volume:
            text += ", and its volume is unknown"
            hint = "give mass, com and inertia in mass.parts"
        if kind is missing[-1]:
            hint += _yaml_for(missing, kinds, keys)
        log.report("E-MASS", text, kind.title, hint)


def _yaml_for(missing: Sequence[PartKind], kinds: Sequence[PartKind], keys: MassSection) -> str:
    """Returns the YAML that gives parts without mass a mass: a density for all, or a line for each."""
    owners: dict[str, set[int]] = {}
    for kind in kinds:
        for occurrence in kind.occurrences:
            owners.setdefault(without_number(occurrence.names[-1]), set()).add(id(kind))
    lines = {}
    for kind in missing:
        for occurrence in kind.occurrences if kind.volume else ():
            plain = without_number(occurrence.names[-1])
            name = plain if owners[plain] == {id(kind)} else occurrence.title
            lines[exact_glob(name)] = float(f"{keys.density * kind.volume:.3g}")
    if not lines:
        return ""
    parts = ", ".join(f"{json.dumps(name, ensure_ascii=False)}: {{mass: {m}}}" for name, m in lines.items())
    all_at_once = f"mass: {{missing: density, density: {keys.density:g}}}"
    return f"; or give all of them in YAML: {all_at_once}  or each [kg]: mass: {{parts: {{{parts}}}}}"


def _inertial(kind: PartKind, mass: float, log: Diagnostics) -> Inertial:
    """Returns the kind's inertial with this mass [kg]: from the user's values, else CAD's, else those of its
    triangles."""
    if mass < 0:
        text = f"its mass is {mass:.4g} kg"
        hint = "correct its material or its mass override in Onshape, or give its mass in mass.parts"
        log.report("E-MASS", text, kind.title, hint)
    if mass <= 0:
        return ZERO
    base = kind.part_mass.inertial if kind.part_mass and kind.part_mass.inertial.mass > 0 else None
    if base is None and kind.shape is not None:
        base = kind.shape.inertial
    com, inertia = kind.overrides.com, kind.overrides.inertia
    if base is None and (com is None or inertia is None):
        log.report("E-MASS", NO_TRIANGLES, kind.title, "give com and inertia too, in mass.parts")
        return ZERO
    base_of_mass = scaled(base, mass) if base is not None else ZERO
    return Inertial(
        mass,
        base_of_mass.com if com is None else frozen(com),
        base_of_mass.inertia if inertia is None else tensor(inertia),
    )


def _check_density(kind: PartKind, log: Diagnostics) -> None:
    """Reports W-DENSITY if the mass of a part does not fit its volume."""
    low, high = PLAUSIBLE_DENSITIES
    mass, volume = kind.mass, kind.volume
    if not mass or not volume or low <= mass / volume <= high:
        return
    text = f"{mass:.4g} kg in {volume:.4g} m³ are {mass / volume:.4g} kg/m³"
    hint = "correct its material or its mass override in Onshape, or its mass in mass.parts"
    log.report("W-DENSITY", f"{text}: not a plausible density of a solid", kind.title, hint)


def part_key(record: Mapping[str, str]) -> PartKey:
    """Returns the part of an instance."""
    return ElementKey.of(record), record["partId"]


def read_masses(bundle: OnshapeBundle) -> dict[PartKey, PartMass]:
    """Returns the mass properties of every part in the bundle's replies.

    A part without a material has mass 0 in a reply, but a volume.
    """
    masses: dict[PartKey, PartMass] = {}
    for studio in bundle.studios:
        for digest in studio.mass:
            with protocol_errors("reply with the mass properties", f"part studio {studio.key.element}"):
                bodies = orjson.loads(bundle.body(digest))["bodies"]
                for part in sorted(set(bodies) - {"-all-"}):
                    volume = _nominal(bodies[part].get("volume"))
                    masses[studio.key, part] = PartMass(_reply_inertial(bodies[part]), volume)
    return masses


def _reply_inertial(body: Mapping[str, Any]) -> Inertial:
    mass = _nominal(body.get("mass"))
    if mass == 0:
        return ZERO
    centroid = numbers(body["centroid"][:3], 3)
    inertia = numbers(body["inertia"][:9], 9).reshape(3, 3)
    return Inertial(mass, frozen(centroid), frozen((inertia + inertia.T) / 2))


def _nominal(values: object) -> float:
    """Returns the nominal value of [nominal, min, max]; 0 if it is missing."""
    if isinstance(values, list):
        values = values[0] if values else 0.0
    return number(values or 0.0)
