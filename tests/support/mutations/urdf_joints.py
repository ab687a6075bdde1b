"""Faults of a URDF's joints."""

import random

from tests.support.mutations.edits import moved, named, numbers, pick, put, sign_of
from tests.support.mutations.kind import Element, Files, Kinds, NothingToChange, Planted

KINDS = Kinds("urdf")


MOVING = "joint[@type='revolute' or @type='continuous' or @type='prismatic']"


def joints(files: Files, rng: random.Random, condition: str = "") -> Element:
    return pick(files.urdf.xpath(f"//{MOVING}{condition}"), rng)


def inertial(files: Files, rng: random.Random) -> Element:
    """The <inertial> of a link with a mass that is no speck, of the robot's own links."""
    own = [one for one in files.urdf.iterfind("link/inertial") if float(one.find("mass").get("value")) > 1e-9]
    return pick(own, rng)


@KINDS.add("axis flipped", "C-MOTION", simcheck="reversed axis")
def _(files: Files, rng: random.Random) -> Planted:
    joint = joints(files, rng)
    axis = joint.find("axis")
    put(axis, "xyz", sign_of(numbers(axis, "xyz")))
    return Planted(named("joint", joint), ("axis",))


@KINDS.add("axis swapped", "C-MOTION")
def _(files: Files, rng: random.Random) -> Planted:
    joint = joints(files, rng)
    axis = joint.find("axis")
    x, y, z = numbers(axis, "xyz")
    put(axis, "xyz", (z, x, y))
    return Planted(named("joint", joint), ("axis",))


@KINDS.add("axis zero", "C-COMPILE", "C-XML", "C-NUMBER", "C-REFERENCE", "C-AXIS", simcheck="zero axis")
def _(files: Files, rng: random.Random) -> Planted:
    joint = joints(files, rng)
    joint.find("axis").set("xyz", "0 0 0")
    return Planted(named("joint", joint), ("axis",))


@KINDS.add("limits swapped", "C-JOINT", simcheck="swapped limits")
def _(files: Files, rng: random.Random) -> Planted:
    joint = joints(files, rng, "[limit/@lower]")
    limit = joint.find("limit")
    low, high = limit.get("lower"), limit.get("upper")
    limit.set("lower", high)
    limit.set("upper", low)
    return Planted(named("joint", joint), ("limit",))


@KINDS.add("limits widened", "C-JOINT")
def _(files: Files, rng: random.Random) -> Planted:
    joint = joints(files, rng, "[limit/@upper]")
    limit = joint.find("limit")
    limit.set("upper", f"{float(limit.get('upper')) + rng.uniform(0.001, 0.5):.9g}")
    return Planted(named("joint", joint), ("limit upper",))


@KINDS.add("limits removed", "C-JOINT")
def _(files: Files, rng: random.Random) -> Planted:
    joint = joints(files, rng, "[limit/@lower]")
    for key in ("lower", "upper"):
        del joint.find("limit").attrib[key]
    return Planted(named("joint", joint), ("limit",))


@KINDS.add("limits in degrees", "C-JOINT", simcheck="limits in degrees")
def _(files: Files, rng: random.Random) -> Planted:
    joint = joints(files, rng, "[@type='revolute'][limit/@lower]")
    for key in ("lower", "upper"):
        joint.find("limit").set(key, f"{float(joint.find('limit').get(key)) * 57.29577951:.9g}")
    return Planted(named("joint", joint), ("limit",))


@KINDS.add("effort changed", "C-JOINT")
def _(files: Files, rng: random.Random) -> Planted:
    joint = joints(files, rng, "[limit/@effort]")
    limit = joint.find("limit")
    limit.set("effort", f"{float(limit.get('effort')) * rng.choice((0.5, 0.99, 10)):.9g}")
    return Planted(named("joint", joint), ("effort",))


@KINDS.add("velocity changed", "C-JOINT")
def _(files: Files, rng: random.Random) -> Planted:
    joint = joints(files, rng, "[limit/@velocity]")
    joint.find("limit").set("velocity", f"{float(joint.find('limit').get('velocity')) * 1.5:.9g}")
    return Planted(named("joint", joint), ("velocity",))


@KINDS.add("damping negative", "C-JOINT", "C-COMPILE")
def _(files: Files, rng: random.Random) -> Planted:
    joint = joints(files, rng, "[dynamics]")
    joint.find("dynamics").set("damping", f"{-rng.uniform(0.01, 1):.6g}")
    return Planted(named("joint", joint), ("damping",))


@KINDS.add("joint type changed", "C-JOINT")
def _(files: Files, rng: random.Random) -> Planted:
    joint = joints(files, rng, "[@type!='continuous']")
    joint.set("type", {"revolute": "prismatic", "prismatic": "revolute"}[joint.get("type")])
    return Planted(named("joint", joint), ("type",))


@KINDS.add("joint fixed", "C-LINKS")
def _(files: Files, rng: random.Random) -> Planted:
    driven = {one.get("joint") for one in files.urdf.iterfind(".//mimic")}
    free = [one for one in files.urdf.xpath(f"//{MOVING}[not(mimic)]") if one.get("name") not in driven]
    joint = pick(free, rng)
    joint.set("type", "fixed")
    return Planted(named("joint", joint), ("name", "type"))


@KINDS.add("joint origin 1 mm off", "C-MOTION")
def _(files: Files, rng: random.Random) -> Planted:
    joint = joints(files, rng)
    moved(joint.find("origin"), "xyz", rng, 0.001)
    return Planted(named("joint", joint), ("origin xyz",))


@KINDS.add("joint origin turned the other way", "C-MOTION")
def _(files: Files, rng: random.Random) -> Planted:
    turned = [
        one
        for one in files.urdf.xpath(f"//{MOVING}")
        if any(0.01 < abs(angle) < 3.13 for angle in numbers(one.find("origin"), "rpy"))
    ]
    joint = pick(turned, rng)
    origin = joint.find("origin")
    put(origin, "rpy", sign_of(numbers(origin, "rpy")))
    return Planted(named("joint", joint), ("origin rpy",))


@KINDS.add("all joints in millimetres", "C-MOTION", simcheck="millimetre units")
def _(files: Files, rng: random.Random) -> Planted:
    return resized(files, 1000.0)


@KINDS.add("all joints far too near", "C-MOTION", simcheck="too small")
def _(files: Files, rng: random.Random) -> Planted:
    return resized(files, 0.01)


def resized(files: Files, factor: float) -> Planted:
    names = []
    for joint in files.urdf.xpath(f"//{MOVING}"):
        origin = joint.find("origin")
        values = numbers(origin, "xyz")
        put(origin, "xyz", [factor * value for value in values])
        names += [named("joint", joint)] if max(map(abs, values)) > 1e-4 else []
    if not names:
        raise NothingToChange
    return Planted(names[0], ("origin xyz",), tuple(names))


@KINDS.add("joint within its parent", "C-MOTION", simcheck="joint inside its parent")
def _(files: Files, rng: random.Random) -> Planted:
    away = [
        one
        for one in files.urdf.xpath(f"//{MOVING}")
        if max(map(abs, numbers(one.find("origin"), "xyz"))) > 1e-3
    ]
    joint = pick(away, rng)
    joint.find("origin").set("xyz", "0 0 0")
    return Planted(named("joint", joint), ("origin xyz",))


@KINDS.add("parent swapped", "C-MOTION")
def _(files: Files, rng: random.Random) -> Planted:
    parents = {
        one.find("child").get("link"): one.find("parent").get("link")
        for one in files.urdf.iter("joint")
        if one.find("child") is not None
    }
    deep = [one for one in files.urdf.xpath(f"//{MOVING}") if one.find("parent").get("link") in parents]
    joint = pick(deep, rng)
    joint.find("parent").set("link", parents[joint.find("parent").get("link")])
    return Planted(named("joint", joint), ("parent", "origin"))
