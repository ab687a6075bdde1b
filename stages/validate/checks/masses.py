"""Mass, centre of mass and inertia of each link are those of its parts in CAD.

The expected values are summed independently over the parts, by second moments, not taken from the links
that the files were written from. A link whose inertial the user gave must have that.
"""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from stages.formats.xml import parse
from stages.robot.check import Check, Finding
from stages.robot.model import Array
from stages.robot.poses import inverse
from stages.validate.compiled import CompiledModel
from stages.validate.coordinates import body_from_link, body_index
from stages.validate.equalities import carriers
from stages.validate.findings import differs, link, worst_first
from stages.validate.lumps import EXACT, UNITS, Lump, differences, expected_lump, merged, moved_lump
from stages.validate.mujoco_abilities import axes_error
from stages.validate.mujoco_poses import placed

CODE = "C-MASS"


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Each link's body, together with the carriers that have a share of it."""
    shares = {} if compiled.urdf else carriers(compiled.model, compiled.robot)
    worst, where = dict.fromkeys(UNITS, 0.0), dict.fromkeys(UNITS, "")
    engine_error = 0.0
    findings: dict[str, list[tuple[float, Finding]]] = {key: [] for key in UNITS}
    for one in compiled.robot.links:
        expected = expected_lump(one)
        place = inverse(body_from_link(compiled.robot, one.name))
        lumps = [_lump(compiled.model, body_index(compiled.model, one.name), place)]
        lumps += [_lump(compiled.model, body, pose) for body, pose in shares.get(one.name, [])]
        total = merged(lumps)
        largest = float(np.abs(expected[2]).max())
        allowed = axes_error(largest) if compiled.urdf and largest else 0.0
        engine_error = max(engine_error, allowed)
        for key, value in differences(total, expected, allowed).items():
            if not value < worst[key]:
                worst[key], where[key] = value, one.name
            if not value <= EXACT:
                element = link(one.name, compiled.urdf)
                findings[key].append((value, _finding(element, key, total, expected, compiled.urdf)))
    for name in _without_inertial(compiled):
        message = "has no inertial, so that each reader makes one up"
        findings["mass"].append((math.inf, Finding(link(name, True), "inertial", message)))
        worst["mass"], where["mass"] = math.inf, name
    for key, unit in UNITS.items():
        if key == "inertia" and engine_error > EXACT:
            unit += ", beyond the error of this MuJoCo's principal axes"
        detail = f"{key} of each link against CAD's parts ({unit}); worst: {where[key]}"
        yield compiled.within(key, worst[key], EXACT, detail, worst_first(findings[key]))


def _without_inertial(compiled: CompiledModel) -> list[str]:
    """The links of a URDF that have mass, and no <inertial>: MuJoCo works one out from their shapes."""
    if not compiled.urdf:
        return []
    bare = {
        one.get("name")
        for one in parse(compiled.path.read_bytes()).iterfind("link")
        if one.find("inertial") is None
    }
    return [one.name for one in compiled.robot.links if one.inertial.mass > 0 and one.name in bare]


def _finding(element: str, key: str, found: Lump, expected: Lump, urdf: bool) -> Finding:
    if key == "mass":
        return differs(element, "inertial mass", found[0], expected[0], "kg")
    if key == "centre of mass":
        return differs(element, f"inertial {'origin' if urdf else 'pos'}", found[1], expected[1], "m")
    moments = [np.linalg.eigvalsh(tensor) for tensor in (found[2], expected[2])]
    turned = float(np.abs(moments[0] - moments[1]).max()) <= EXACT * float(np.abs(moments[1]).max())
    if urdf:
        rows, columns = np.triu_indices(3)
        pairs = [one[2][rows, columns] for one in (found, expected)]
        most = int(np.abs(pairs[0] - pairs[1]).argmax())
        name = "xyz"[rows[most]] + "xyz"[columns[most]]
        return differs(element, f"inertial inertia i{name}", pairs[0][most], pairs[1][most], "kg m²")
    if turned:
        return Finding(
            element, "inertial quat", "turns the principal axes of inertia otherwise than expected"
        )
    return differs(element, "inertial diaginertia", moments[0], moments[1], "kg m², by size")


def _lump(model: Any, body: int, link_from_body: Array) -> Lump:
    """The mass properties of a body, in the frame of a link."""
    axes = placed(model.body_iquat[body], model.body_ipos[body])
    tensor = axes[:3, :3] @ np.diag(model.body_inertia[body]) @ axes[:3, :3].T
    return moved_lump(float(model.body_mass[body]), axes[:3, 3], tensor, link_from_body)
