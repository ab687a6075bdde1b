"""Masses as CAD has them: part studio replies to one inertial per part, and what lacks one.

Onshape gives each value as [nominal, min, max]; `inertia` is 27 numbers of which the first nine
are the nominal tensor, row by row, about the centroid, in the part studio's axes, with true signs.
A composite part has an entry of its own; its constituents have theirs, which nobody uses unless they
stand in the assembly themselves. A sheet has no mass, unless one is given to it.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import orjson

from stages.graph.assembly import Assembly
from stages.graph.bodies import Bodies
from stages.robot.bundle import Bundle, StudioKey
from stages.robot.errors import Diagnostic, ProtocolError
from stages.robot.inertia import ZERO
from stages.robot.model import Inertial, frozen

PartKey = tuple[StudioKey, str]
Masses = Mapping[PartKey, tuple[Inertial, float]]

SHEET = "sheet"
_KNOWN = {"solid", "composite", SHEET}


def part_key(record: Mapping[str, str]) -> PartKey:
    """What a part instance is one of."""
    return StudioKey.of(record), record["partId"]


def read_masses(bundle: Bundle) -> dict[PartKey, tuple[Inertial, float]]:
    """(inertial in the part's frame, volume [m³]) of every part in the bundle's replies.

    A part without material has mass 0 there, and its volume all the same.
    """
    found: dict[PartKey, tuple[Inertial, float]] = {}
    for studio in bundle.studios:
        for digest in studio.mass:
            try:
                bodies = orjson.loads(bundle.body(digest))["bodies"]
                for part in sorted(set(bodies) - {"-all-"}):
                    volume = _first(bodies[part].get("volume"))
                    found[studio.key, part] = _inertial(bodies[part]), volume
            except (KeyError, TypeError, ValueError, AttributeError) as error:
                msg = f"the mass properties are not in the shape of the API ({type(error).__name__}: {error})"
                hint = "fetch them again, or make the bundle again; if it stays so, the API has changed"
                raise ProtocolError(msg, f"part studio {studio.key.element}", hint) from error
    return found


def with_sheets(masses: Masses, assembly: Assembly, found: list[Diagnostic]) -> Masses:
    """The masses with zeros for the sheets that have none; each is told once."""
    more: dict[PartKey, tuple[Inertial, float]] = {}
    for part in assembly.parts:
        key = part_key(part.record)
        if assembly.body_types.get(key) != SHEET or key in more:
            continue
        inertial, volume = masses.get(key, (ZERO, 0.0))
        if inertial.mass <= 0:
            more[key] = ZERO, volume
            found.append(
                Diagnostic(
                    "W-BODY-TYPE",
                    "a sheet without mass: it is seen, but neither weighs nor collides",
                    part.title,
                    "thicken it, or give it a mass override, in Onshape",
                )
            )
    return {**masses, **more}


def check_masses(assembly: Assembly, masses: Masses, problems: list[Diagnostic]) -> None:
    """Files each kind of part that has no usable mass, once."""
    told: set[PartKey] = set()
    for part in assembly.parts:
        key = part_key(part.record)
        if key in told:
            continue
        told.add(key)
        kind = assembly.body_types.get(key, "solid")
        if kind not in _KNOWN:
            what = f"a {kind} body is not supported"
            problems.append(Diagnostic("E-BODY-TYPE", what, part.title, "suppress it"))
        elif key not in masses:
            problems.append(Diagnostic("E-MASS", "the mass reply does not know this part", part.title))
        elif masses[key][0].mass <= 0 and kind != SHEET:
            hint = "give it a material, or a mass override, in Onshape"
            problems.append(Diagnostic("E-MASS", "the part has no mass", part.title, hint))


def check_link_masses(
    bodies: Bodies,
    assembly: Assembly,
    masses: Masses,
    links: Sequence[str],
    problems: list[Diagnostic],
) -> None:
    """Files the links that are sheets without mass and nothing else; `links`: names by body."""
    for body, members in enumerate(bodies.members):
        if sum(masses[part_key(assembly.occurrences[path].record)][0].mass for path in members) <= 0:
            what = "the link has no mass: it is nothing but sheets"
            hint = "fasten it to a solid part, or thicken it, in Onshape"
            problems.append(Diagnostic("E-MASS", what, links[body], hint))


def _inertial(body: Mapping[str, Any]) -> Inertial:
    centroid = (body.get("centroid") or [0.0] * 3)[:3]
    inertia = (body.get("inertia") or [0.0] * 9)[:9]
    tensor = frozen(inertia).reshape(3, 3)
    return Inertial(float(_first(body.get("mass"))), frozen(centroid), frozen((tensor + tensor.T) / 2))


def _first(values: object) -> float:
    if isinstance(values, list):
        return float(values[0]) if values else 0.0
    return float(values or 0.0)  # type: ignore[arg-type]
