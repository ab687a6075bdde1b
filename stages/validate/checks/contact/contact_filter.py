"""Which pairs of shapes may collide is what the robot says: in MuJoCo's own rules, whatever the pose."""

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
from linkwright.stages.validate.model.coordinates import SAME
from linkwright.stages.validate.model.shapes import named_geom

TAGS = frozenset({"contact", "exclude", "pair", "geom", "contype", "conaffinity", "flag"})
"""Of the user's own XML: what changes which shapes collide."""

GEOM = mujoco.mjtObj.mjOBJ_GEOM

Grid = npt.NDArray[np.bool_]


def check(compiled: CompiledModel) -> Iterator[Check]:
    """URDF says nothing of contact; and what the user's own XML says of it is the user's."""
    geometry = compiled.geometry
    if compiled.urdf or geometry is None or not geometry.shapes:
        return
    if any(TAGS & {*one.sets, *one.added_tags} for one in compiled.written.amendments.changes):
        return
    model, found = compiled.model, []
    colliders = _colliders(compiled, geometry)
    excluded = {(one.link_a, one.link_b): one.geoms for one in geometry.excludes}
    outside = {int(one) for one in model.exclude_signature}
    pairs, by_source, meant = _pairs(model), _of_source(compiled), set[frozenset[int]]()
    for one, other in sorted(_candidates(model, geometry, colliders)):
        (first, own), (second, others) = colliders[one], colliders[other]
        if never_collide(model, *(int(model.geom_bodyid[geoms[0]]) for geoms in (own, others))):
            continue
        may = _may_collide(model, own, others, outside) | _among(own, others, by_source & pairs.keys())
        wanted = np.full(may.shape, geometry.self_contact)
        apart = excluded.get((first, second))
        if apart is not None:
            wanted[tuple(np.array(apart).T) if apart else ...] = False
        kept = {frozenset((own[a], others[b])) for a, b in np.argwhere(wanted & ~may)}
        meant |= kept
        may |= _among(own, others, pairs.keys() & kept)
        if (may != wanted).any():
            extra, fewer = int((may & ~wanted).sum()), int((wanted & ~may).sum())
            words = f"{count(fewer, 'pair')} of their shapes cannot collide, but must"
            if extra:
                words = f"{count(extra, 'pair')} of their shapes may collide, but must not"
            found.append(Finding(f'exclude "{first}" "{second}"', "body1, body2", words))
    words = "they collide by it whatever else the file says; the robot has no such pair"
    idle = sorted(pairs.keys() - meant - by_source, key=sorted)
    found += [Finding(_title(model, geoms), "geom1, geom2", words) for geoms in idle]
    found += _changed_pairs(model, {geoms: pairs[geoms] for geoms in pairs if geoms not in by_source})
    detail = f"what may collide of {count(_judged(model, colliders), 'pair')} of links"
    yield compiled.within("contact filter", float(len(found)), 0.0, detail, few(found))


def _candidates(
    model: Any, geometry: Geometry, colliders: list[tuple[str, list[int]]]
) -> set[tuple[int, int]]:
    """The pairs of places in `colliders` that may be other than they must: those that the file or the robot
    leaves out, and those whose bits alone say so. Of all others the bits say what must be, and links are of
    few kinds by their bits: a large robot has too many pairs to look at each."""
    place = {link: at for at, (link, _) in enumerate(colliders)}
    of_body = {int(model.geom_bodyid[geoms[0]]): at for at, (_, geoms) in enumerate(colliders)}
    named = [(place.get(one.link_a), place.get(one.link_b)) for one in geometry.excludes]
    named += [
        (of_body.get(int(one) >> 16), of_body.get(int(one) & 0xFFFF)) for one in model.exclude_signature
    ]
    found = {(min(a, b), max(a, b)) for a, b in named if a is not None and b is not None and a != b}
    kinds: dict[frozenset[tuple[int, int]], list[int]] = {}
    for at, (_, geoms) in enumerate(colliders):
        bits = frozenset((int(model.geom_contype[geom]), int(model.geom_conaffinity[geom])) for geom in geoms)
        kinds.setdefault(bits, []).append(at)
    for (one, members), (other, others) in combinations_with_replacement(kinds.items(), 2):
        if any(bool(a[0] & b[1] or b[0] & a[1]) != geometry.self_contact for a in one for b in other):
            found |= {(min(a, b), max(a, b)) for a in members for b in others if a != b}
    return found


def _judged(model: Any, colliders: list[tuple[str, list[int]]]) -> int:
    """How many pairs of links there are but for those of `never_collide`."""
    welds = Counter(int(model.body_weldid[model.geom_bodyid[geoms[0]]]) for _, geoms in colliders)
    never = sum(math.comb(number, 2) for number in welds.values())
    if not model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_FILTERPARENT:
        for weld, number in welds.items():
            above = int(model.body_weldid[model.body_parentid[weld]])
            never += number * welds[above] if weld and above else 0
    return math.comb(len(colliders), 2) - never


def _pairs(model: Any) -> dict[frozenset[int], int]:
    """The geoms that collide as pairs, whatever their bits and excludes say → the pair."""
    pairs = zip(model.pair_geom1, model.pair_geom2, strict=True)
    return {frozenset(map(int, geoms)): number for number, geoms in enumerate(pairs)}


def _of_source(compiled: CompiledModel) -> set[frozenset[int]]:
    """The geoms that the robot's MJCF source has as pairs."""
    sections = () if compiled.robot.mjcf is None else compiled.robot.mjcf.sections
    pairs = (element for element in children_of(sections, "contact") if element.tag == "pair")
    return {frozenset(index_of(compiled.model, GEOM, name) for _, name in pair.named()) for pair in pairs}


def _among(own: Sequence[int], others: Sequence[int], pairs: Set[frozenset[int]]) -> Grid:
    """Which of these geoms are such pairs."""
    return np.array([[frozenset((geom, other)) in pairs for other in others] for geom in own])


def _changed_pairs(model: Any, pairs: Mapping[frozenset[int], int]) -> Iterator[Finding]:
    """Pairs with other properties of contact than MuJoCo gives two such geoms without a pair: that of its
    source, mj_contactParam."""
    for geoms, pair in pairs.items():
        one, other = sorted(geoms)
        for key, wanted in _mixed(model, one, other).items():
            value = getattr(model, f"pair_{key}")[pair]
            if np.abs(value - wanted).max() > SAME:
                words = f"is {value}, but {wanted} without the pair"
                yield Finding(_title(model, geoms), key, words)


def _mixed(model: Any, one: int, other: int) -> dict[str, npt.NDArray[np.float64]]:
    """The properties of contact that two geoms (`one` < `other`) have together, by the names of MjModel; the
    margin is the sum, as in MuJoCo since 3.5, whichever version is installed."""
    spread = [0, 0, 1, 2, 2]
    geoms = [one, other]
    priority = model.geom_priority[geoms]
    if priority[0] != priority[1]:
        geoms = [geoms[int(priority.argmax())]]
    share = model.geom_solmix[geoms] / model.geom_solmix[geoms].sum()
    solref = model.geom_solref[geoms]
    mean = (share[:, None] * solref).sum(axis=0)
    return {
        "dim": model.geom_condim[geoms].max(),
        "friction": model.geom_friction[geoms].max(axis=0)[spread],
        "solref": mean if (solref[:, 0] > 0).all() else solref.min(axis=0),
        "solimp": (share[:, None] * model.geom_solimp[geoms]).sum(axis=0),
        "margin": model.geom_margin[[one, other]].sum(),
    }


def _title(model: Any, geoms: Iterable[int]) -> str:
    return f"pair of {' and '.join(named_geom(model, geom) for geom in sorted(geoms))}"


def _colliders(compiled: CompiledModel, geometry: Geometry) -> list[tuple[str, list[int]]]:
    """The colliding geoms of each link that has as many as the robot: where it has not, that is found
    elsewhere."""
    model, shapes, found = compiled.model, geometry.by_link(), []
    for link in compiled.robot.links:
        body = body_index(model, link.name)
        first = int(model.body_geomadr[body])
        every = range(first, first + int(model.body_geomnum[body]))
        solid = [geom for geom in every if model.geom_contype[geom] or model.geom_conaffinity[geom]]
        number = len(shapes[link.name, "collision"])
        if number and len(solid) >= number:
            found.append((link.name, solid[:number]))
    return found


def _may_collide(model: Any, own: list[int], others: list[int], excluded: set[int]) -> Grid:
    """By the rules of MuJoCo's documentation, "Collision detection": the bits of both, and that their bodies
    are not `excluded`, by their signatures."""
    bodies = [int(model.geom_bodyid[geoms[0]]) for geoms in (own, others)]
    bits = [(model.geom_contype[geoms], model.geom_conaffinity[geoms]) for geoms in (own, others)]
    meet: Grid = (bits[0][0][:, None] & bits[1][1] | bits[1][0] & bits[0][1][:, None]) != 0
    signature = (min(bodies) << 16) + max(bodies)
    return meet & (signature not in excluded)
