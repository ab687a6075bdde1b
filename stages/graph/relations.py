"""Relations between joints: q₂ = −k·q₁, or +k·q₁ when reversed, in the mates' own values.

The sign is measured on recorded gears. The offset comes from the saved pose; a chain of relations
is flattened to the joint that drives it.
"""

import math
from collections.abc import Mapping, Sequence

from stages.graph.assembly import Assembly, MateRelation, Path
from stages.graph.naming import Names
from stages.robot.errors import Diagnostic
from stages.robot.model import Joint, Relation
from stages.robot.names import free, legal

ZERO_OFFSET = 1e-6
TURN = 2 * math.pi


def read_relations(
    assembly: Assembly,
    names: Names,
    joints: Sequence[Joint],
    found: list[Diagnostic],
    problems: list[Diagnostic],
) -> tuple[Relation, ...]:
    """Every gear relation as follower = multiplier · driver + offset, sorted by follower."""
    by_name = {joint.name: joint for joint in joints}
    direct: dict[str, Relation] = {}
    taken = set(names.joints.values())
    for relation in sorted(assembly.relations, key=lambda r: (r.title, r.owner, r.feature)):
        pair = _joints_of(relation, names, by_name)
        if relation.type != "GEAR" or pair is None or relation.ratio == 0:
            found.append(_not_modelled(relation, pair))
            continue
        driver, follower = pair
        if follower.name in direct or driver.name == follower.name:
            what = "itself" if driver.name == follower.name else "two joints"
            problems.append(
                Diagnostic(
                    "E-RELATION",
                    f"the joint {follower.name!r} would follow {what}",
                    relation.title,
                    "remove one relation, or swap the order of its mates",
                )
            )
            continue
        name = free(legal(relation.title.rsplit("/", 1)[-1]) or "relation", taken)
        taken.add(name)
        direct[follower.name] = _gear(name, relation, driver, follower, found)
    return _flattened(direct, problems)


def related_mates(assembly: Assembly) -> set[tuple[Path, str]]:
    """(owner, feature) of every mate that a relation names."""
    return {mate for relation in assembly.relations for mate in relation.mates}


def _joints_of(
    relation: MateRelation, names: Names, by_name: Mapping[str, Joint]
) -> tuple[Joint, Joint] | None:
    if len(relation.mates) != 2:
        return None
    pair = [by_name.get(names.joints.get(mate, "")) for mate in relation.mates]
    if pair[0] is None or pair[1] is None:
        return None
    return pair[0], pair[1]


def _not_modelled(relation: MateRelation, pair: object) -> Diagnostic:
    if relation.type != "GEAR":
        why = f"a {relation.type} relation is not supported yet"
    elif pair is None:
        why = "the relation names a mate that is no joint of the tree (broken, rigid, or closing a loop)"
    else:
        why = "the relation has the ratio 0"
    return Diagnostic("W-RELATION", f"{why}: its joints move independently", relation.title)


def _gear(
    name: str, relation: MateRelation, driver: Joint, follower: Joint, found: list[Diagnostic]
) -> Relation:
    multiplier = relation.ratio if relation.reverse else -relation.ratio
    offset = _offset(multiplier, driver, follower)
    if abs(offset) > ZERO_OFFSET:
        if abs(_offset(-multiplier, driver, follower)) <= ZERO_OFFSET:
            found.append(
                Diagnostic(
                    "I-RELATION-SIGN",
                    "the saved pose fits the opposite direction, which is believed",
                    relation.title,
                )
            )
            multiplier, offset = -multiplier, 0.0
        else:
            found.append(
                Diagnostic(
                    "W-RELATION-OFFSET",
                    f"the saved pose has an offset of {offset:.6g} in this relation, which is kept",
                    relation.title,
                )
            )
    return Relation(
        name, follower.name, driver.name, multiplier, offset if abs(offset) > ZERO_OFFSET else 0.0
    )


def _offset(multiplier: float, driver: Joint, follower: Joint) -> float:
    """What is left of the follower's saved value; whole turns of either joint are taken off."""
    rest = follower.saved - multiplier * driver.saved
    driver_turns = (0, 1, -1, 2, -2) if driver.type == "revolute" else (0,)
    best = math.inf
    for turns in driver_turns:
        value = rest - multiplier * TURN * turns
        if follower.type == "revolute":
            value = math.remainder(value, TURN)
        if abs(value) < abs(best) - ZERO_OFFSET:
            best = value
        if turns == 0 and abs(best) <= ZERO_OFFSET:
            break
    # Turning the driver is only believed where it explains the pose; else the plain offset stands.
    if abs(best) > ZERO_OFFSET:
        return math.remainder(rest, TURN) if follower.type == "revolute" else rest
    return best


def _flattened(direct: Mapping[str, Relation], problems: list[Diagnostic]) -> tuple[Relation, ...]:
    flat = []
    for follower in sorted(direct):
        relation = direct[follower]
        multiplier, offset, driver = relation.multiplier, relation.offset, relation.driver
        seen = {follower}
        while driver in direct and driver not in seen:
            seen.add(driver)
            above = direct[driver]
            multiplier, offset = multiplier * above.multiplier, offset + multiplier * above.offset
            driver = above.driver
        if driver in seen:
            problems.append(
                Diagnostic(
                    "E-RELATION",
                    f"the relations of {', '.join(sorted(seen))} run in a circle",
                    relation.name,
                    "remove one of them",
                )
            )
            continue
        flat.append(Relation(relation.name, follower, driver, multiplier, offset))
    return tuple(flat)
