"""Finds the equalities of a compiled model, their errors, and the bodies that they connect."""

from collections.abc import Iterator, Mapping
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.mujoco.names import body_index, index_of, joint_index
from linkwright.stages.robot.check import Finding
from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.model.robot import Array, Loop, Robot
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import differs, largest_error, named, shown, worst_first
from linkwright.stages.validate.model.coordinates import BY_EQUALITY, ENGINE_TOLERANCE
from linkwright.stages.validate.model.poses import placed

LOOP_TOLERANCE = 1e-6
"""Tolerance of loops and relations [m, rad]: CAD's own solver leaves a smaller error."""


STIFF_SOLIMP = (0.9999, 0.9999, 0.001)
"""`solimp` of equalities that close loops and relate joints: the largest impedance that MuJoCo allows."""


def solver_differences(
    compiled: CompiledModel,
    index: int,
    element: str,
    solref: tuple[float, float],
    by_source: Mapping[str, str] | None = None,
) -> Iterator[Finding]:
    """Yields the differences of an equality's solver parameters. Expected are those of an MJCF source
    (`by_source`), else `solref`, as far as the time step allows it, and `STIFF_SOLIMP`. Parameters that the
    user's own XML sets are not compared."""
    model, (first, ratio) = compiled.model, solref
    # Two time steps are the shortest time constant that MuJoCo holds.
    expected: tuple[float, ...] = (
        (max(first, 2.0 * float(model.opt.timestep)), ratio) if first > 0 else solref
    )
    impedance: tuple[float, ...] = STIFF_SOLIMP
    if by_source is not None:
        expected, impedance = (tuple(map(float, by_source[key].split())) for key in ("solref", "solimp"))
    if not np.allclose(model.eq_solref[index], expected, rtol=ENGINE_TOLERANCE) and not compiled.sets(
        "solref"
    ):
        yield differs(element, "solref", model.eq_solref[index], expected)
    impedance_found = model.eq_solimp[index][: len(impedance)]
    if not np.allclose(impedance_found, impedance, rtol=ENGINE_TOLERANCE) and not compiled.sets("solimp"):
        yield differs(element, "solimp", impedance_found, impedance)
    scale = float((by_source or {}).get("torquescale", 1.0))
    is_weld = model.eq_type[index] == mujoco.mjtEq.mjEQ_WELD
    scale_found = float(model.eq_data[index][10])
    if (
        is_weld
        and not np.isclose(scale_found, scale, rtol=ENGINE_TOLERANCE)
        and not compiled.sets("torquescale")
    ):
        yield differs(element, "torquescale", scale_found, scale)


def violation(model: Any, data: Any) -> float:
    """Returns the largest error of the equalities at a pose [m, rad]. The error of a relation is that of the
    joint that moves less."""
    rows = np.flatnonzero(data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY)
    is_relation = model.eq_type[data.efc_id[rows]] == mujoco.mjtEq.mjEQ_JOINT
    factors = np.abs(model.eq_data[data.efc_id[rows], 1])
    scale = np.where(is_relation, np.maximum(1.0, factors), 1.0)
    return float(np.abs(data.efc_pos[rows] / scale).max(initial=0.0))


def open_equalities(model: Any, data: Any) -> tuple[Finding, ...]:
    """Returns findings on the equalities that are violated at a pose, the largest error first."""
    rows = np.flatnonzero(data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY)
    largest_errors: dict[int, float] = {}
    for row in rows:
        index = int(data.efc_id[row])
        largest_errors[index] = largest_error((largest_errors.get(index, 0.0), abs(float(data.efc_pos[row]))))
    findings = []
    for index, value in largest_errors.items():
        kind = mujoco.mjtEq(int(model.eq_type[index])).name.removeprefix("mjEQ_").lower()
        element = named(kind, model.equality(index).name)
        attribute = "polycoef" if kind == "joint" else "site1, site2"
        if value > LOOP_TOLERANCE:
            findings.append((value, Finding(element, attribute, f"is open by {shown(value)} m or rad")))
    return worst_first(findings)


def carriers(model: Any, robot: Robot) -> dict[str, list[tuple[int, Array]]]:
    """Maps each link to (body, link_from_body) of the carriers that are welded to it."""
    by_link: dict[str, list[tuple[int, Array]]] = {}
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
            by_link.setdefault(link, []).append((carrier, link_site @ inverse(carrier_site)))
    return by_link


def equality_index(model: Any, loop: Loop) -> int:
    """Returns the index of a loop's equality; -1 if it is missing."""
    return index_of(model, mujoco.mjtObj.mjOBJ_EQUALITY, loop.name)


def sites(model: Any, equality: int) -> tuple[int, int]:
    """Returns the indices of the two sites of an equality, or of the two bodies if it names bodies."""
    return int(model.eq_obj1id[equality]), int(model.eq_obj2id[equality])


def bodies(model: Any, equality: int) -> frozenset[int]:
    """Returns the bodies that a `connect` or `weld` connects, whether it names these or sites on them."""
    pair = sites(model, equality)
    if int(model.eq_objtype[equality]) == mujoco.mjtObj.mjOBJ_SITE:
        pair = int(model.site_bodyid[pair[0]]), int(model.site_bodyid[pair[1]])
    return frozenset(pair)


def ends(model: Any, loop: Loop) -> tuple[int, int]:
    """Returns the two bodies that an equality connects. For a loop with a carrier these are the carrier and
    the loop's link that is not the carrier's parent (-1 if both are other bodies)."""
    a, b = body_index(model, loop.link_a), body_index(model, loop.link_b)
    if loop.type in BY_EQUALITY:
        return a, b
    carrier = int(model.jnt_bodyid[joint_index(model, loop.dofs[0].name)])
    return carrier, {a: b, b: a}.get(int(model.body_parentid[carrier]), -1)
