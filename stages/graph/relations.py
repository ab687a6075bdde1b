"""Relations between joints: q₂ = −k·q₁, or +k·q₁ when reversed, in the mates' own values.

The sign is measured on recorded gears. The offset comes from the saved pose; a chain of relations
is flattened to the joint that drives it.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from stages.graph.assembly import Assembly, MateRelation, Path
from stages.graph.naming import Names
from stages.robot.errors import Diagnostic
from stages.robot.model import Joint, Relation
from stages.robot.names import free, legal

ZERO_OFFSET = 1e-6
"""An offset [rad or m] that the saved pose leaves below this is rounding."""


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
        name = free(legal(relation.title.rsplit("/", 1)[-1]) or "relation", taken)
        taken.add(name)
        gear = _gear(name, relation, driver, follower, found)
        if gear.follower in direct:
            # Which mate was picked first is no physics: the other one may as well follow.
            gear = _turned_round(gear)
        if gear.follower in direct or gear.follower == gear.driver:
            problems.append(
                Diagnostic(
                    "E-RELATION",
                    f"the joints {gear.driver!r} and {gear.follower!r} are related already",
                    relation.title,
                    "remove the relation that says too much",
                )
            )
            continue
        direct[gear.follower] = gear
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


def _turned_round(relation: Relation) -> Relation:
    """The same relation, solved for its driver."""
    return Relation(
        relation.name,
        follower=relation.driver,
        driver=relation.follower,
        multiplier=1 / relation.multiplier,
        offset=-relation.offset / relation.multiplier,
    )


def _offset(multiplier: float, driver: Joint, follower: Joint) -> float:
    """What is left of the follower's saved value, whole turns taken off."""
    rest = follower.saved - multiplier * driver.saved
    return math.remainder(rest, math.tau) if follower.type == "revolute" else rest


def on_their_drivers(joints: Sequence[Joint], relations: Sequence[Relation]) -> tuple[Joint, ...]:
    """The joints, with followers saved at the turn that their relation gives.

    The pose alone tells an angle up to whole turns; what drives it tells the turn.
    """
    saved = {joint.name: joint.saved for joint in joints}
    given = {r.follower: r.multiplier * saved[r.driver] + r.offset for r in relations}
    return tuple(
        replace(joint, saved=joint.saved + math.tau * round((given[joint.name] - joint.saved) / math.tau))
        if joint.name in given and joint.type == "revolute"
        else joint
        for joint in joints
    )


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
