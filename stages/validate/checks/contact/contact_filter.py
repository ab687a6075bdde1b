"""Checks that MuJoCo's rules let the same pairs of shapes collide as the robot's, whatever the pose."""

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from itertools import combinations_with_replacement
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from linkwright.stages.mujoco.names import body_index, index_of
from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.mjcf_extras import children_of
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.contact_errors import never_collide
from linkwright.stages.validate.findings import few
from linkwright.stages.validate.model.coordinates import ENGINE_TOLERANCE
from linkwright.stages.validate.model.shapes import named_geom

TAGS = frozenset({"contact", "exclude", "pair", "geom", "contype", "conaffinity", "flag"})
"""Elements and attributes of the user's own XML that change which shapes collide."""

GEOM = mujoco.mjtObj.mjOBJ_GEOM

PairGrid = npt.NDArray[np.bool_]


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Compares the pairs. It skips a URDF, which says nothing about contact, and files with the user's own
    XML for contact."""
    geometry = compiled.geometry
    if compiled.urdf or geometry is None or not geometry.shapes:
        return
    if any(TAGS & {*change.sets, *change.added_tags} for change in compiled.written.amendments.changes):
        return
    model, findings = compiled.model, list[Finding]()
    colliders = _colliders(compiled, geometry)
    excluded = {(exclude.link_a, exclude.link_b): exclude.geoms for exclude in geometry.excludes}
    outside = {int(signature) for signature in model.exclude_signature}
    pairs, source_pairs, needed_pairs = _explicit_pairs(model), _source_pairs(compiled), set[frozenset[int]]()
    for first_place, second_place in sorted(_candidates(model, geometry, colliders)):
        (first, first_geoms), (second, second_geoms) = colliders[first_place], colliders[second_place]
        if never_collide(model, *(int(model.geom_bodyid[geoms[0]]) for geoms in (first_geoms, second_geoms))):
            continue
        may = _may_collide(model, first_geoms, second_geoms, outside) | _pair_grid(
            first_geoms, second_geoms, source_pairs & pairs.keys()
        )
        expected = np.full(may.shape, geometry.self_contact)
        excluded_geoms = excluded.get((first, second))
        if excluded_geoms is not None:
            expected[tuple(np.array(excluded_geoms).T) if excluded_geoms else ...] = False
        missing_pairs = {
            frozenset((first_geoms[a], second_geoms[b])) for a, b in np.argwhere(expected & ~may)
        }
        needed_pairs |= missing_pairs
        may |= _pair_grid(first_geoms, second_geoms, pairs.keys() & missing_pairs)
        if (may != expected).any():
            extra, missing = int((may & ~expected).sum()), int((expected & ~may).sum())
            message = f"{count(missing, 'pair')} of their shapes cannot collide, but must"
            if extra:
                message = f"{count(extra, 'pair')} of their shapes may collide, but must not"
            findings.append(Finding(f'exclude "{first}" "{second}"', "body1, body2", message))
    message = "it lets them collide whatever else the file says; the robot has no such pair"
    idle_pairs = sorted(pairs.keys() - needed_pairs - source_pairs, key=sorted)
    findings += [Finding(_title(model, geoms), "geom1, geom2", message) for geoms in idle_pairs]
    findings += _changed_pairs(model, {geoms: pairs[geoms] for geoms in pairs if geoms not in source_pairs})
    detail = f"which shapes may collide, for {count(_pair_count(model, colliders), 'pair')} of links"
    yield compiled.within("contact filter", float(len(findings)), 0.0, detail, few(findings))


def _candidates(
    model: Any, geometry: Geometry, colliders: list[tuple[str, list[int]]]
) -> set[tuple[int, int]]:
    """Returns the pairs of places in `colliders` that need a check, since a large robot has too many pairs.

    These are the pairs that the file or the robot excludes, and the pairs that the bits alone exclude. All
    other pairs are decided by the bits, of which there are only a few kinds.
    """
    place = {link: at for at, (link, _) in enumerate(colliders)}
    of_body = {int(model.geom_bodyid[geoms[0]]): at for at, (_, geoms) in enumerate(colliders)}
    named = [(place.get(exclude.link_a), place.get(exclude.link_b)) for exclude in geometry.excludes]
    signatures = [int(signature) for signature in model.exclude_signature]
    named += [(of_body.get(signature >> 16), of_body.get(signature & 0xFFFF)) for signature in signatures]
    candidates = {(min(a, b), max(a, b)) for a, b in named if a is not None and b is not None and a != b}
    kinds: dict[frozenset[tuple[int, int]], list[int]] = {}
    for at, (_, geoms) in enumerate(colliders):
        bits = frozenset((int(model.geom_contype[geom]), int(model.geom_conaffinity[geom])) for geom in geoms)
        kinds.setdefault(bits, []).append(at)
    for (bits, members), (other_bits, other_members) in combinations_with_replacement(kinds.items(), 2):
        meet = (bool(a[0] & b[1] or b[0] & a[1]) for a in bits for b in other_bits)
        if any(may != geometry.self_contact for may in meet):
            candidates |= {(min(a, b), max(a, b)) for a in members for b in other_members if a != b}
    return candidates


def _pair_count(model: Any, colliders: list[tuple[str, list[int]]]) -> int:
    """Returns the number of pairs of links, without the pairs that never collide."""
    welds = Counter(int(model.body_weldid[model.geom_bodyid[geoms[0]]]) for _, geoms in colliders)
    never = sum(math.comb(number, 2) for number in welds.values())
    if not model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_FILTERPARENT:
        for weld, number in welds.items():
            above = int(model.body_weldid[model.body_parentid[weld]])
            never += number * welds[above] if weld and above else 0
    return math.comb(len(colliders), 2) - never


def _explicit_pairs(model: Any) -> dict[frozenset[int], int]:
    """Maps the two geoms of each <pair>, which collide whatever their bits and excludes are, to its index."""
    pairs = zip(model.pair_geom1, model.pair_geom2, strict=True)
    return {frozenset(map(int, geoms)): number for number, geoms in enumerate(pairs)}


def _source_pairs(compiled: CompiledModel) -> set[frozenset[int]]:
    """Returns the pairs of geoms that the robot's MJCF source lists."""
    sections = () if compiled.robot.mjcf is None else compiled.robot.mjcf.sections
    pairs = (element for element in children_of(sections, "contact") if element.tag == "pair")
    return {frozenset(index_of(compiled.model, GEOM, name) for _, name in pair.named()) for pair in pairs}


def _pair_grid(first: Sequence[int], second: Sequence[int], pairs: Set[frozenset[int]]) -> PairGrid:
    """Returns, for each geom of `first` and of `second`, whether they are among `pairs`."""
    return np.array([[frozenset((geom, other)) in pairs for other in second] for geom in first])


def _changed_pairs(model: Any, pairs: Mapping[frozenset[int], int]) -> Iterator[Finding]:
    """Yields pairs whose contact properties differ from those that MuJoCo gives the same two geoms without a
    pair (mj_contactParam)."""
    for geoms, pair in pairs.items():
        first, second = sorted(geoms)
        for key, expected in _mixed_properties(model, first, second).items():
            value = getattr(model, f"pair_{key}")[pair]
            if np.abs(value - expected).max() > ENGINE_TOLERANCE:
                message = f"is {value}, but {expected} without the pair"
                yield Finding(_title(model, geoms), key, message)


def _mixed_properties(model: Any, first: int, second: int) -> dict[str, npt.NDArray[np.float64]]:
    """Returns the contact properties of two geoms (`first` < `second`) together, by the names of MjModel. The
    margin is the sum, as in MuJoCo since 3.5, whichever version is installed."""
    friction_indices = [0, 0, 1, 2, 2]
    geoms = [first, second]
    priority = model.geom_priority[geoms]
    if priority[0] != priority[1]:
        geoms = [geoms[int(priority.argmax())]]
    solmix = model.geom_solmix[geoms]
    # As in MuJoCo: geoms that are both without a share have equal shares.
    share = solmix / solmix.sum() if solmix.sum() > 0.0 else np.full(len(geoms), 1.0 / len(geoms))
    solref = model.geom_solref[geoms]
    mean = (share[:, None] * solref).sum(axis=0)
    return {
        "dim": model.geom_condim[geoms].max(),
        "friction": model.geom_friction[geoms].max(axis=0)[friction_indices],
        "solref": mean if (solref[:, 0] > 0).all() else solref.min(axis=0),
        "solimp": (share[:, None] * model.geom_solimp[geoms]).sum(axis=0),
        "margin": model.geom_margin[[first, second]].sum(),
    }


def _title(model: Any, geoms: Iterable[int]) -> str:
    return f"pair of {' and '.join(named_geom(model, geom) for geom in sorted(geoms))}"


def _colliders(compiled: CompiledModel, geometry: Geometry) -> list[tuple[str, list[int]]]:
    """Returns the colliding geoms of each link that has at least the robot's colliders; other checks report
    missing geoms."""
    model, shapes, colliders = compiled.model, geometry.by_link(), list[tuple[str, list[int]]]()
    for link in compiled.robot.links:
        body = body_index(model, link.name)
        first = int(model.body_geomadr[body])
        geoms = range(first, first + int(model.body_geomnum[body]))
        solid = [geom for geom in geoms if model.geom_contype[geom] or model.geom_conaffinity[geom]]
        number = len(shapes[link.name, "collision"])
        if number and len(solid) >= number:
            colliders.append((link.name, solid[:number]))
    return colliders


def _may_collide(model: Any, first: list[int], second: list[int], excluded: set[int]) -> PairGrid:
    """Applies the rules of MuJoCo's documentation, "Collision detection": the bits of both geoms, and whether
    the signature of their bodies is among `excluded`."""
    bodies = [int(model.geom_bodyid[geoms[0]]) for geoms in (first, second)]
    bits = [(model.geom_contype[geoms], model.geom_conaffinity[geoms]) for geoms in (first, second)]
    meet: PairGrid = (bits[0][0][:, None] & bits[1][1] | bits[1][0] & bits[0][1][:, None]) != 0
    signature = (min(bodies) << 16) + max(bodies)
    return meet & (signature not in excluded)
