"""The equalities of a compiled model: their errors, and the bodies that they connect."""

from collections.abc import Iterator, Mapping
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.mujoco.names import body_index, index_of, joint_index
from linkwright.stages.robot.check import Finding
from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.model.robot import Array, Loop, Robot
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import differs, named, shown, worst_first
from linkwright.stages.validate.model.coordinates import BY_EQUALITY, SAME
from linkwright.stages.validate.model.poses import placed

CLOSED = 1e-6
"""Loops and relations [m, rad]: the error that CAD's own solver leaves is below this."""


STIFF = (0.9999, 0.9999, 0.001)
"""`solimp` of what closes loops and relates joints: the impedance that MuJoCo allows at most."""


def held_differences(
    compiled: CompiledModel,
    index: int,
    element: str,
    solref: tuple[float, float],
    by_source: Mapping[str, str] | None = None,
) -> Iterator[Finding]:
    """How an equality is held otherwise than it must be: as an MJCF source says (`by_source`), else with
    `solref`, as far as the time step lets it, and `STIFF`. What the user's own XML sets is the user's."""
    model, (first, ratio) = compiled.model, solref
    # Two steps are the stiffest that MuJoCo holds.
    wanted: tuple[float, ...] = (max(first, 2.0 * float(model.opt.timestep)), ratio) if first > 0 else solref
    impedance: tuple[float, ...] = STIFF
    if by_source is not None:
        wanted, impedance = (tuple(map(float, by_source[key].split())) for key in ("solref", "solimp"))
    if not np.allclose(model.eq_solref[index], wanted, rtol=SAME) and not compiled.sets("solref"):
        yield differs(element, "solref", model.eq_solref[index], wanted)
    found = model.eq_solimp[index][: len(impedance)]
    if not np.allclose(found, impedance, rtol=SAME) and not compiled.sets("solimp"):
        yield differs(element, "solimp", found, impedance)
    scale = float((by_source or {}).get("torquescale", 1.0))
    weld = model.eq_type[index] == mujoco.mjtEq.mjEQ_WELD
    own = float(model.eq_data[index][10])
    if weld and not np.isclose(own, scale, rtol=SAME) and not compiled.sets("torquescale"):
        yield differs(element, "torquescale", own, scale)


def violation(model: Any, data: Any) -> float:
    """The errors of the equalities at a pose [m, rad]; for a relation at the joint that it moves less."""
    rows = np.flatnonzero(data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY)
    related = model.eq_type[data.efc_id[rows]] == mujoco.mjtEq.mjEQ_JOINT
    factors = np.abs(model.eq_data[data.efc_id[rows], 1])
    scale = np.where(related, np.maximum(1.0, factors), 1.0)
    return float(np.abs(data.efc_pos[rows] / scale).max(initial=0.0))


def open_equalities(model: Any, data: Any) -> tuple[Finding, ...]:
    """The equalities that a pose leaves open, the widest first."""
    rows = np.flatnonzero(data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY)
    widest: dict[int, float] = {}
    for row in rows:
        index = int(data.efc_id[row])
        widest[index] = max(widest.get(index, 0.0), abs(float(data.efc_pos[row])))
    found = []
    for index, value in widest.items():
        kind = mujoco.mjtEq(int(model.eq_type[index])).name.removeprefix("mjEQ_").lower()
        element = named(kind, model.equality(index).name)
        attribute = "polycoef" if kind == "joint" else "site1, site2"
        if value > CLOSED:
            found.append((value, Finding(element, attribute, f"is open by {shown(value)} m or rad")))
    return worst_first(found)


def carriers(model: Any, robot: Robot) -> dict[str, list[tuple[int, Array]]]:
    """By link: (body, link_from_body) of the carriers that are welded to it."""
    found: dict[str, list[tuple[int, Array]]] = {}
    for loop in robot.loops:
        index = equality_index(model, loop)
        if loop.type in BY_EQUALITY or index < 0:
            continue
        carrier, _ = ends(model, loop)
        bodies = {body_index(model, link): link for link in (loop.link_a, loop.link_b)}
        order = sorted(sites(model, index), key=lambda site: int(model.site_bodyid[site]) == carrier)
        link_site, carrier_site = (placed(model.site_quat[s], model.site_pos[s]) for s in order)
        link = bodies.get(int(model.site_bodyid[order[0]]))
        if link is not None:
            found.setdefault(link, []).append((carrier, link_site @ inverse(carrier_site)))
    return found


def equality_index(model: Any, loop: Loop) -> int:
    return index_of(model, mujoco.mjtObj.mjOBJ_EQUALITY, loop.name)


def sites(model: Any, equality: int) -> tuple[int, int]:
    return int(model.eq_obj1id[equality]), int(model.eq_obj2id[equality])


def bodies(model: Any, equality: int) -> frozenset[int]:
    """The bodies that a `connect` or `weld` is between, whether it names these or sites of theirs."""
    pair = sites(model, equality)
    if int(model.eq_objtype[equality]) == mujoco.mjtObj.mjOBJ_SITE:
        pair = int(model.site_bodyid[pair[0]]), int(model.site_bodyid[pair[1]])
    return frozenset(pair)


def ends(model: Any, loop: Loop) -> tuple[int, int]:
    """The two bodies that an equality connects. For a loop with a carrier: the carrier, and the one of the
    loop's links that is not its parent (-1 if neither is)."""
    a, b = body_index(model, loop.link_a), body_index(model, loop.link_b)
    if loop.type in BY_EQUALITY:
        return a, b
    carrier = int(model.jnt_bodyid[joint_index(model, loop.dofs[0].name)])
    return carrier, {a: b, b: a}.get(int(model.body_parentid[carrier]), -1)
