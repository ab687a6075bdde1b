"""Faults of what an MJCF has beside its bodies: loops, relations, actuators, keyframes, sensors, excludes."""

import random

from lxml import etree

from tests.support.mutations.edits import moved, named, numbers, pick, put
from tests.support.mutations.kind import Element, Files, Kinds, NothingToChange, Planted

KINDS = Kinds("mjcf")


@KINDS.add("loop's site 1 mm off", "C-LOOP", "C-CLOSED")
def _(files: Files, rng: random.Random) -> Planted:
    closing = {node.get(key): node for node in files.mjcf.xpath("//connect") for key in ("site1", "site2")}
    site = pick([one for one in files.mjcf.iter("site") if one.get("name") in closing], rng)
    moved(site, "pos", rng, 0.001)
    return Planted(named("site", site), ("pos", "site1"), (named("connect", closing[site.get("name")]),))


@KINDS.add("loop's equality removed", "C-LOOP")
def _(files: Files, rng: random.Random) -> Planted:
    one = pick(files.mjcf.xpath("//equality/connect | //equality/weld"), rng)
    one.getparent().remove(one)
    return Planted(f'connect "{one.get("name").removesuffix("_axis")}"', ("site1",))


@KINDS.add("loop's equality switched off", "C-LOOP")
def _(files: Files, rng: random.Random) -> Planted:
    one = pick(files.mjcf.xpath("//equality/connect | //equality/weld"), rng)
    one.set("active", "false")
    return Planted(named(one.tag, one), ("active",))


@KINDS.add("loop's equality slack", "C-LOOP")
def _(files: Files, rng: random.Random) -> Planted:
    one = pick(files.mjcf.xpath("//equality/connect | //equality/weld"), rng)
    put(one, "solref", (rng.uniform(0.1, 0.5), 1.0))
    return Planted(named(one.tag, one), ("solref",))


@KINDS.add("bodies welded together", "C-LOOP")
def _(files: Files, rng: random.Random) -> Planted:
    first, second = rng.sample([one.get("name") for one in files.mjcf.xpath("//body")], 2)
    etree.SubElement(files.mjcf.find("equality"), "weld", name="glue", body1=first, body2=second)
    return Planted('weld "glue"', ("site1",))


@KINDS.add("relation switched off", "C-RELATION")
def _(files: Files, rng: random.Random) -> Planted:
    one = pick(files.mjcf.xpath("//equality/joint"), rng)
    one.set("active", "false")
    return Planted(named("joint", one), ("active",))


@KINDS.add("relation slack", "C-RELATION")
def _(files: Files, rng: random.Random) -> Planted:
    one = pick(files.mjcf.xpath("//equality/joint"), rng)
    put(one, "solref", (rng.uniform(0.1, 0.5), 1.0))
    return Planted(named("joint", one), ("solref",))


@KINDS.add("relation's sign", "C-RELATION")
def _(files: Files, rng: random.Random) -> Planted:
    one = pick(files.mjcf.xpath("//equality/joint"), rng)
    offset, factor, *rest = numbers(one, "polycoef")
    put(one, "polycoef", (offset, -factor, *rest))
    return Planted(named("joint", one), ("polycoef",))


@KINDS.add("relation's offset", "C-RELATION")
def _(files: Files, rng: random.Random) -> Planted:
    one = pick(files.mjcf.xpath("//equality/joint"), rng)
    offset, *rest = numbers(one, "polycoef")
    put(one, "polycoef", (offset + rng.uniform(0.01, 0.2), *rest))
    return Planted(named("joint", one), ("polycoef",))


@KINDS.add("relation removed", "C-RELATION")
def _(files: Files, rng: random.Random) -> Planted:
    one = pick(files.mjcf.xpath("//equality/joint"), rng)
    one.getparent().remove(one)
    return Planted(named("joint", one), ("", "polycoef"))


@KINDS.add("actuator on another joint", "C-ACTUATOR")
def _(files: Files, rng: random.Random) -> Planted:
    one = actuator(files, rng)
    every = {node.get("name") for node in files.mjcf.xpath("//body/joint[@name][not(@type='ball')]")}
    one.set("joint", rng.choice(sorted(every - {one.get("joint")})))
    return Planted(named(one.tag, one), ("joint",))


def actuator(files: Files, rng: random.Random, condition: str = "") -> Element:
    return pick(files.mjcf.xpath(f"//actuator/*[@joint]{condition}"), rng)


@KINDS.add("actuator removed", "C-ACTUATOR")
def _(files: Files, rng: random.Random) -> Planted:
    one = actuator(files, rng)
    one.getparent().remove(one)
    for key in files.mjcf.iter("key"):
        if key.get("ctrl"):
            key.set("ctrl", " ".join(key.get("ctrl").split()[:-1]))
    return Planted(named(one.tag, one), ("name",))


@KINDS.add("gear's sign", "C-ACTUATOR")
def _(files: Files, rng: random.Random) -> Planted:
    one = actuator(files, rng)
    first = numbers(one, "gear")[0] if one.get("gear") else 1.0
    one.set("gear", f"{-first:g}")
    return Planted(named(one.tag, one), ("gear",))


@KINDS.add("servo without stiffness", "C-ACTUATOR")
def _(files: Files, rng: random.Random) -> Planted:
    one = actuator(files, rng, "[@kp]")
    one.set("kp", "0")
    return Planted(named(one.tag, one), ("kp",))


@KINDS.add("range of control", "C-ACTUATOR")
def _(files: Files, rng: random.Random) -> Planted:
    one = actuator(files, rng, "[@ctrlrange]")
    low, high = numbers(one, "ctrlrange")
    put(one, "ctrlrange", (low, high + rng.uniform(0.01, 1)))
    return Planted(named(one.tag, one), ("ctrlrange",))


@KINDS.add("range of force", "C-ACTUATOR")
def _(files: Files, rng: random.Random) -> Planted:
    one = actuator(files, rng)
    one.set("forcerange", "-0.001 0.001")
    return Planted(named(one.tag, one), ("forcerange",))


@KINDS.add("keyframe off", "C-KEYFRAME")
def _(files: Files, rng: random.Random) -> Planted:
    key = pick(files.mjcf.xpath("//key[@qpos]"), rng)
    values = numbers(key, "qpos")
    at = rng.randrange(7 if files.mjcf.find(".//freejoint") is not None else 0, len(values))
    values[at] += rng.choice((-1, 1)) * rng.uniform(0.01, 0.5)
    put(key, "qpos", values)
    return Planted(named("key", key), ("qpos",))


@KINDS.add("keyframe removed", "C-KEYFRAME")
def _(files: Files, rng: random.Random) -> Planted:
    key = pick(files.mjcf.xpath("//key"), rng)
    key.getparent().remove(key)
    return Planted(named("key", key), ("name",))


@KINDS.add("control of the keyframe", "C-ACTUATOR")
def _(files: Files, rng: random.Random) -> Planted:
    key = pick(files.mjcf.xpath("//key[@name='home'][@ctrl]"), rng)
    values = numbers(key, "ctrl")
    values[rng.randrange(len(values))] += rng.uniform(0.01, 0.5)
    put(key, "ctrl", values)
    return Planted(named("key", key), ("ctrl",))


@KINDS.add("keyframe moves", "C-KEYFRAME")
def _(files: Files, rng: random.Random) -> Planted:
    key = pick(files.mjcf.xpath("//key[not(//freejoint)][not(//joint/@type = 'ball')]"), rng)
    put(key, "qvel", [rng.uniform(0.1, 1) for _ in files.mjcf.xpath("//body/joint")])
    return Planted(named("key", key), ("qvel",))


@KINDS.add("sensor on another place", "C-SENSOR")
def _(files: Files, rng: random.Random) -> Planted:
    keys = ("site", "joint", "actuator", "objname")
    one = pick([node for node in files.mjcf.xpath("//sensor/*") if any(node.get(key) for key in keys)], rng)
    key = next(key for key in keys if one.get(key))
    pool = {
        "site": "//body//site/@name",
        "joint": "//body/joint[not(@type='ball')]/@name",
        "actuator": "//actuator/*/@name",
        "objname": "//body//site/@name" if one.get("objtype") == "site" else "//body/@name",
    }
    others = sorted(set(map(str, files.mjcf.xpath(pool[key]))) - {one.get(key)})
    if not others:
        raise NothingToChange
    one.set(key, rng.choice(others))
    return Planted(named(one.tag, one), (key, "site", "objname"))


@KINDS.add("sensor removed", "C-SENSOR")
def _(files: Files, rng: random.Random) -> Planted:
    one = pick(files.mjcf.xpath("//sensor/*"), rng)
    one.getparent().remove(one)
    return Planted(named(one.tag, one), ("name",))


@KINDS.add("site of a frame moved", "C-MOTION")
def _(files: Files, rng: random.Random) -> Planted:
    used = {node.get(key) for node in files.mjcf.xpath("//equality/*") for key in ("site1", "site2")}
    site = pick(
        [one for one in files.mjcf.iter("site") if one.get("name") and one.get("name") not in used], rng
    )
    moved(site, "pos", rng, 0.001)
    return Planted(named("site", site), ("pos",))


@KINDS.add("freejoint removed", "C-LINKS")
def _(files: Files, rng: random.Random) -> Planted:
    one = pick(files.mjcf.xpath("//freejoint"), rng)
    body = one.getparent()
    body.remove(one)
    for key in files.mjcf.iter("key"):
        key.set("qpos", " ".join(key.get("qpos").split()[7:]))
    return Planted(named("body", body), ("freejoint",))


@KINDS.add("freejoint added", "C-LINKS", "C-COMPILE")
def _(files: Files, rng: random.Random) -> Planted:
    if files.mjcf.find(".//freejoint") is not None:
        raise NothingToChange
    body = files.mjcf.find("worldbody/body")
    body.insert(0, etree.Element("freejoint", name="floats"))
    for key in files.mjcf.iter("key"):
        key.set("qpos", "0 0 0 1 0 0 0 " + key.get("qpos"))
    return Planted('joint "floats"', ("type",))


@KINDS.add("exclude removed", "C-EXCLUDE")
def _(files: Files, rng: random.Random) -> Planted:
    one = pick(files.mjcf.xpath("//exclude"), rng)
    one.getparent().remove(one)
    return exclude(one.get("body1"), one.get("body2"))


def exclude(first: str, second: str) -> Planted:
    one, other = (f'exclude "{a}" "{b}"' for a, b in ((first, second), (second, first)))
    return Planted(one, ("body1",), (other,))


@KINDS.add("exclude added", "C-EXCLUDE")
def _(files: Files, rng: random.Random) -> Planted:
    holder = files.mjcf.find("contact")
    if holder is None:
        holder = etree.SubElement(files.mjcf, "contact")
    known = {frozenset((one.get("body1"), one.get("body2"))) for one in holder.iter("exclude")}
    solid = files.mjcf.xpath("//body[geom[contains(@class, 'collision')]]")
    pairs = [
        (one.get("name"), other.get("name"))
        for one in solid
        for other in solid
        if one.get("name") < other.get("name")
        and one.getparent() is not other
        and other.getparent() is not one
        and frozenset((one.get("name"), other.get("name"))) not in known
    ]
    if not pairs:
        raise NothingToChange
    first, second = rng.choice(pairs)
    etree.SubElement(holder, "exclude", body1=first, body2=second)
    return exclude(first, second)


def root(files: Files) -> Element:
    """The body of the robot's root."""
    return files.mjcf.find("worldbody/body")


@KINDS.add("root 5 mm up", "C-PLACE")
def _(files: Files, rng: random.Random) -> Planted:
    x, y, z = numbers(root(files), "pos") if root(files).get("pos") else (0.0, 0.0, 0.0)
    put(root(files), "pos", (x, y, z + 0.005))
    return Planted(named("body", root(files)), ("pos",))


@KINDS.add("root turned by 90 degrees", "C-PLACE")
def _(files: Files, rng: random.Random) -> Planted:
    put(root(files), "quat", (0.5**0.5, 0, 0, 0.5**0.5))
    return Planted(named("body", root(files)), ("quat",))


def _of_home(files: Files, at: int, change: tuple[float, ...]) -> Planted:
    """The numbers of the free joint at `home`, from this one on."""
    if files.mjcf.find(".//freejoint") is None:
        raise NothingToChange
    (key,) = files.mjcf.xpath("//key[@name='home']")
    values = numbers(key, "qpos")
    values[at : at + len(change)] = change
    put(key, "qpos", values)
    return Planted('key "home"', ("qpos",))


@KINDS.add("free base 5 cm up at home", "C-PLACE")
def _(files: Files, rng: random.Random) -> Planted:
    height = numbers(root(files), "pos")[2] if root(files).get("pos") else 0.0
    return _of_home(files, 2, (height + 0.05,))


@KINDS.add("free base turned at home", "C-PLACE")
def _(files: Files, rng: random.Random) -> Planted:
    return _of_home(files, 3, (0.8, 0.0, 0.0, 0.6))
