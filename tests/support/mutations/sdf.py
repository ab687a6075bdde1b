"""Faults of an SDF."""

import random

from lxml import etree

from tests.support.mutations.edits import named, pick
from tests.support.mutations.kind import Element, Files, Kinds, Planted

KINDS = Kinds("sdf")


def within(node: Element, path: str, text: str) -> None:
    """Puts a text into the element at the end of a path, whose elements are made where there are none."""
    for tag in path.split("/"):
        found = node.find(tag)
        node = etree.SubElement(node, tag) if found is None else found
    node.text = text


def shape(files: Files, rng: random.Random, role: str, condition: str = "") -> tuple[Element, Planted]:
    """A shape, and what a finding of it names."""
    found = pick(files.sdf.xpath(f"//link/{role}{condition}"), rng)
    return found, Planted(named("link", found.getparent()), (role,))


def link(files: Files, rng: random.Random) -> Element:
    return pick(files.sdf.xpath("//link"), rng)


@KINDS.add("mesh scaled", "C-SDF")
def _(files: Files, rng: random.Random) -> Planted:
    one, planted = shape(files, rng, "visual", "[geometry/mesh]")
    within(one, "geometry/mesh/scale", rng.choice(("2 2 2", "0.001 0.001 0.001", "1 1 -1")))
    return planted


@KINDS.add("mesh of another part", "C-SDF")
def _(files: Files, rng: random.Random) -> Planted:
    one, planted = shape(files, rng, rng.choice(("visual", "collision")), "[geometry/mesh]")
    uri = one.find("geometry/mesh/uri")
    others = {other.text for other in files.sdf.iter("uri")} - {uri.text}
    uri.text = rng.choice(sorted(others))
    return planted


@KINDS.add("collider gone", "C-SDF")
def _(files: Files, rng: random.Random) -> Planted:
    one, planted = shape(files, rng, "collision")
    one.getparent().remove(one)
    return planted


@KINDS.add("visual gone", "C-SDF")
def _(files: Files, rng: random.Random) -> Planted:
    one, planted = shape(files, rng, "visual")
    one.getparent().remove(one)
    return planted


@KINDS.add("collider moved", "C-SDF")
def _(files: Files, rng: random.Random) -> Planted:
    one, planted = shape(files, rng, "collision", "[not(pose)]")
    within(one, "pose", f"0 {rng.uniform(0.0001, 0.1):.6g} 0 0 0 0")
    return planted


@KINDS.add("visual turned", "C-SDF")
def _(files: Files, rng: random.Random) -> Planted:
    one, planted = shape(files, rng, "visual", "[not(pose)]")
    within(one, "pose", f"0 0 0 0 0 {rng.uniform(0.001, 3):.6g}")
    return planted


@KINDS.add("collider ten times as large", "C-SDF")
def _(files: Files, rng: random.Random) -> Planted:
    one, planted = shape(files, rng, "collision", "[.//size or .//radius]")
    size = pick(one.xpath(".//size | .//radius"), rng)
    size.text = " ".join(f"{10 * float(word):.12g}" for word in size.text.split())
    return planted


@KINDS.add("collider without friction", "C-SDF")
def _(files: Files, rng: random.Random) -> Planted:
    one, planted = shape(files, rng, "collision")
    within(one, "surface/friction/ode/mu", "0")
    return planted


@KINDS.add("all pass through a collider", "C-SDF")
def _(files: Files, rng: random.Random) -> Planted:
    one, planted = shape(files, rng, "collision")
    within(one, "surface/contact/collide_bitmask", "0x00" if rng.random() < 0.5 else "0")
    return planted


@KINDS.add("link without weight", "C-SDF")
def _(files: Files, rng: random.Random) -> Planted:
    one = link(files, rng)
    within(one, "gravity", rng.choice(("false", "0")))
    return Planted(named("link", one), ("gravity",))


@KINDS.add("link that no force moves", "C-SDF")
def _(files: Files, rng: random.Random) -> Planted:
    one = link(files, rng)
    within(one, "kinematic", "true")
    return Planted(named("link", one), ("kinematic",))


@KINDS.add("links collide with each other", "C-SDF")
def _(files: Files, rng: random.Random) -> Planted:
    model = files.sdf.find("model")
    own = model.findtext("self_collide") == "true"
    within(model, "self_collide", "false" if own else "true")
    return Planted(named("model", model), ("self_collide",))


@KINDS.add("collider that misses the world", "C-SDF")
def _(files: Files, rng: random.Random) -> Planted:
    one, planted = shape(files, rng, "collision")
    within(one, "surface/contact/collide_bitmask", rng.choice(("0", "256", "0xff00")))
    return planted


@KINDS.add("model elsewhere", "C-SDF")
def _(files: Files, rng: random.Random) -> Planted:
    model = files.sdf.find("model")
    words = (model.findtext("pose") or "0 0 0 0 0 0").split()
    # A free robot's height depends on its joints, which the MJCF may start elsewhere.
    at = rng.choice((0, 1, 3, 4, 5))
    words[at] = f"{float(words[at]) + rng.uniform(0.001, 1):.6g}"
    within(model, "pose", " ".join(words))
    return Planted(named("model", model), ("pose",))


@KINDS.add("model renamed", "C-SDF")
def _(files: Files, rng: random.Random) -> Planted:
    model = files.sdf.find("model")
    model.set("name", "other")
    return Planted(named("model", model), ("name",))


@KINDS.add("limits without effect", "C-SDF")
def _(files: Files, rng: random.Random) -> Planted:
    joint = pick(files.sdf.xpath("//joint[@type='revolute'][axis/limit/lower]"), rng)
    joint.set("type", "continuous")
    return Planted(named("joint", joint), ("type",))


@KINDS.add("mass 1 % off", "C-SDF")
def _(files: Files, rng: random.Random) -> Planted:
    one = link(files, rng)
    mass = one.find("inertial/mass")
    mass.text = f"{1.01 * float(mass.text):.12g}"
    return Planted(named("link", one), ("mass",))
