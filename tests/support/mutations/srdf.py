"""Faults of an SRDF."""

import random

from lxml import etree

from tests.support.mutations.edits import named, pick
from tests.support.mutations.kind import Element, Files, Kinds, NothingToChange, Planted

KINDS = Kinds("srdf")


def chain(files: Files, rng: random.Random) -> tuple[Element, Planted]:
    """A chain, and what a finding of its group names."""
    found = pick(files.srdf.xpath("/robot/group/chain"), rng)
    return found, Planted(named("group", found.getparent()), ("chain",))


def pair(files: Files, rng: random.Random, reason: str) -> tuple[Element, Planted]:
    found = pick(files.srdf.xpath(f"/robot/disable_collisions[@reason='{reason}']"), rng)
    return found, of_pair(found)


def of_pair(node: Element) -> Planted:
    return Planted(f'disable_collisions "{node.get("link1")}" "{node.get("link2")}"', ("reason",))


def moving(files: Files) -> list[str]:
    """The joints that the group of all has."""
    return sorted({one.get("name") for one in files.srdf.iterfind("group_state/joint")})


def state(files: Files, rng: random.Random) -> tuple[Element, Planted]:
    """The value of a joint in a pose."""
    found = pick(files.srdf.xpath("/robot/group_state/joint"), rng)
    above = found.getparent()
    element = f'{named("group_state", above)} of group "{above.get("group")}"'
    return found, Planted(element, (f"joint {found.get('name')}",))


@KINDS.add("link that is not there", "C-SRDF")
def _(files: Files, rng: random.Random) -> Planted:
    one, _ = pair(files, rng, "Adjacent")
    one.set("link2", f"{one.get('link2')}_x")
    return Planted(of_pair(one).element, ("link2",))


@KINDS.add("joint that is not there", "C-SRDF")
def _(files: Files, rng: random.Random) -> Planted:
    one = pick(files.srdf.xpath("/robot/group/joint"), rng)
    one.set("name", f"{one.get('name')}_x")
    return Planted(named("group", one.getparent()), ("joint",))


@KINDS.add("chain ends elsewhere", "C-SRDF")
def _(files: Files, rng: random.Random) -> Planted:
    one, planted = chain(files, rng)
    links = {node.get("link2") for node in files.srdf.iterfind("disable_collisions")}
    one.set("tip_link", rng.choice(sorted(links - {one.get("tip_link")})))
    return planted


@KINDS.add("chain begins elsewhere", "C-SRDF")
def _(files: Files, rng: random.Random) -> Planted:
    one, planted = chain(files, rng)
    links = {node.get("link2") for node in files.srdf.iterfind("disable_collisions")}
    one.set("base_link", rng.choice(sorted(links - {one.get("base_link")})))
    return planted


@KINDS.add("joint taken out of a group", "C-SRDF")
def _(files: Files, rng: random.Random) -> Planted:
    one = pick(files.srdf.xpath("/robot/group[@name='all']/joint"), rng)
    one.getparent().remove(one)
    return Planted('group "all"', ("joint", "name"))


@KINDS.add("group of a frame gone", "C-SRDF")
def _(files: Files, rng: random.Random) -> Planted:
    frames = {one.get("link") for one in files.srdf.iterfind("disable_collisions")}
    group = pick(files.srdf.xpath("/robot/group[@name='tool' or @name='Mast' or @name='mast']"), rng)
    assert group.get("name") not in frames
    group.getparent().remove(group)
    return Planted(named("group", group), ("name",))


@KINDS.add("hand on another link", "C-SRDF")
def _(files: Files, rng: random.Random) -> Planted:
    one = pick(files.srdf.findall("end_effector"), rng)
    links = {node.get("link1") for node in files.srdf.iterfind("disable_collisions")}
    one.set("parent_link", rng.choice(sorted(links - {one.get("parent_link")})))
    return Planted(named("end_effector", one), ("parent_link", "group", "parent_group"))


@KINDS.add("hand of another group", "C-SRDF")
def _(files: Files, rng: random.Random) -> Planted:
    one = pick(files.srdf.findall("end_effector"), rng)
    attribute = rng.choice(("group", "parent_group"))
    others = {node.get("name") for node in files.srdf.findall("group")} - {one.get(attribute)}
    one.set(attribute, rng.choice(sorted(others)))
    return Planted(named("end_effector", one), (attribute,))


@KINDS.add("pose elsewhere", "C-SRDF")
def _(files: Files, rng: random.Random) -> Planted:
    one, planted = state(files, rng)
    one.set("value", f"{float(one.get('value')) + rng.choice((1e-4, 0.1, -7)):.12g}")
    return planted


@KINDS.add("pose without a joint", "C-SRDF")
def _(files: Files, rng: random.Random) -> Planted:
    one, planted = state(files, rng)
    one.getparent().remove(one)
    return planted


@KINDS.add("pose removed", "C-SRDF")
def _(files: Files, rng: random.Random) -> Planted:
    one, planted = state(files, rng)
    files.srdf.remove(one.getparent())
    return Planted(planted.element, ("name",))


@KINDS.add("pose beyond limits", "C-SRDF")
def _(files: Files, rng: random.Random) -> Planted:
    one, _ = state(files, rng)
    added = etree.SubElement(files.srdf, "group_state", dict(one.getparent().attrib), name="far")
    for joint in one.getparent():
        etree.SubElement(added, "joint", joint.attrib)
    limited = pick([node for node in added if node.get("name") in ("shoulder", "lift", "Neck", "Reach")], rng)
    limited.set("value", rng.choice(("50", "-50")))
    return Planted('group_state "far"', (f"joint {limited.get('name')}",))


@KINDS.add("reason Adjacent for links that are not", "C-SRDF")
def _(files: Files, rng: random.Random) -> Planted:
    one, planted = pair(files, rng, "Never")
    one.set("reason", rng.choice(("Adjacent", "User", "Default")))
    return planted


@KINDS.add("reason Never for links that are next to each other", "C-SRDF")
def _(files: Files, rng: random.Random) -> Planted:
    one, planted = pair(files, rng, "Adjacent")
    one.set("reason", "Never")
    return planted


def _switched_off(files: Files, rng: random.Random, reason: str) -> Planted:
    every = files.srdf.findall("disable_collisions")
    links = sorted({node.get(key) for node in every for key in ("link1", "link2")})
    off = {frozenset((node.get("link1"), node.get("link2"))) for node in every}
    free = [(a, b) for a in links for b in links if a < b and frozenset((a, b)) not in off]
    if not free:
        raise NothingToChange
    first, second = rng.choice(free)
    return of_pair(
        etree.SubElement(files.srdf, "disable_collisions", link1=first, link2=second, reason=reason)
    )


@KINDS.add("collision of a pair switched off", "C-SRDF")
def _(files: Files, rng: random.Random) -> Planted:
    return _switched_off(files, rng, "User")


@KINDS.add("reason Never for links that may meet", "C-SRDF")
def _(files: Files, rng: random.Random) -> Planted:
    return _switched_off(files, rng, "Never")


@KINDS.add("pair that never meets left out", "C-SRDF")
def _(files: Files, rng: random.Random) -> Planted:
    one, planted = pair(files, rng, "Never")
    files.srdf.remove(one)
    return planted


@KINDS.add("pair collides again", "C-SRDF")
def _(files: Files, rng: random.Random) -> Planted:
    one, planted = pair(files, rng, rng.choice(("Adjacent", "Default")))
    files.srdf.remove(one)
    return planted


@KINDS.add("base fixed or floating", "C-SRDF")
def _(files: Files, rng: random.Random) -> Planted:
    one = files.srdf.find("virtual_joint")
    one.set("type", "floating" if one.get("type") == "fixed" else "fixed")
    return Planted(named("virtual_joint", one), ("type",))


@KINDS.add("base on another link", "C-SRDF")
def _(files: Files, rng: random.Random) -> Planted:
    one = files.srdf.find("virtual_joint")
    links = {node.get("link2") for node in files.srdf.iterfind("disable_collisions")}
    one.set("child_link", rng.choice(sorted(links - {one.get("child_link")})))
    return Planted(named("virtual_joint", one), ("child_link",))


@KINDS.add("driven joint passive", "C-SRDF")
def _(files: Files, rng: random.Random) -> Planted:
    passive = {one.get("name") for one in files.srdf.iterfind("passive_joint")}
    name = rng.choice(sorted({*moving(files)} - passive))
    etree.SubElement(files.srdf, "passive_joint", name=name)
    return Planted(f'passive_joint "{name}"', ("name",))


@KINDS.add("robot renamed", "C-SRDF")
def _(files: Files, rng: random.Random) -> Planted:
    files.srdf.set("name", "other")
    return Planted(named("robot", files.srdf), ("name",))
