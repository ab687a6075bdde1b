"""Faults of an MJCF's joints, bodies and inertials."""

import random

from tests.support.mutations.edits import moved, named, numbers, pick, put, sign_of
from tests.support.mutations.kind import Element, Files, Kinds, Planted

KINDS = Kinds("mjcf")


def named_joint(files: Files, rng: random.Random, condition: str = "") -> Element:
    return pick(files.mjcf.xpath(f"//body/joint[@name]{condition}"), rng)


def body_of(node: Element) -> Element:
    return next(node.iterancestors("body"))


def moving_bodies(files: Files, rng: random.Random) -> Element:
    """Bodies with joints, below the first."""
    return pick(files.mjcf.xpath("//worldbody/body//body[joint]"), rng)


@KINDS.add("axis flipped", "C-MOTION", simcheck="reversed axis")
def _(files: Files, rng: random.Random) -> Planted:
    joint = named_joint(files, rng, "[not(@type='ball')]")
    put(joint, "axis", sign_of(numbers(joint, "axis") if joint.get("axis") else [0, 0, 1]))
    return Planted(named("joint", joint), ("axis",))


@KINDS.add("axis swapped", "C-MOTION")
def _(files: Files, rng: random.Random) -> Planted:
    joint = named_joint(files, rng, "[not(@type='ball')]")
    x, y, z = numbers(joint, "axis") if joint.get("axis") else (0.0, 0.0, 1.0)
    put(joint, "axis", (z, x, y))
    return Planted(named("joint", joint), ("axis",))


@KINDS.add("joint's place 1 mm off", "C-MOTION")
def _(files: Files, rng: random.Random) -> Planted:
    joint = named_joint(files, rng, "[not(contains(@class, 'slide'))]")
    axis = numbers(joint, "axis") if joint.get("axis") else [0.0, 0.0, 1.0]
    place = [0.0, 0.0, 0.0]
    place[min(range(3), key=lambda at: abs(axis[at]))] = 0.001
    put(joint, "pos", place)
    return Planted(named("joint", joint), ("pos",))


@KINDS.add("range widened", "C-JOINT")
def _(files: Files, rng: random.Random) -> Planted:
    joint = named_joint(files, rng, "[@range]")
    low, high = numbers(joint, "range")
    put(joint, "range", (low - rng.uniform(0.001, 0.3), high))
    return Planted(named("joint", joint), ("range",))


@KINDS.add("range swapped", "C-JOINT", "C-COMPILE", simcheck="swapped limits")
def _(files: Files, rng: random.Random) -> Planted:
    joint = named_joint(files, rng, "[@range]")
    put(joint, "range", numbers(joint, "range")[::-1])
    return Planted(named("joint", joint), ("range",))


@KINDS.add("range removed", "C-JOINT")
def _(files: Files, rng: random.Random) -> Planted:
    joint = named_joint(files, rng, "[@range]")
    del joint.attrib["range"]
    return Planted(named("joint", joint), ("range",))


@KINDS.add("angles read as degrees", "C-JOINT")
def _(files: Files, rng: random.Random) -> Planted:
    files.mjcf.find("compiler").set("angle", "degree")
    turning = [
        one.get("name") for one in files.mjcf.xpath("//body/joint[@range][not(contains(@class, 'slide'))]")
    ]
    return Planted(f'joint "{turning[0]}"', ("range",), tuple(f'joint "{name}"' for name in turning))


@KINDS.add("damping negative", "C-JOINT", "C-COMPILE")
def _(files: Files, rng: random.Random) -> Planted:
    joint = named_joint(files, rng)
    joint.set("damping", "-0.5")
    return Planted(named("joint", joint), ("damping",))


@KINDS.add("armature changed", "C-JOINT")
def _(files: Files, rng: random.Random) -> Planted:
    joint = named_joint(files, rng)
    joint.set("armature", f"{rng.uniform(0.1, 1):.6g}")
    return Planted(named("joint", joint), ("armature",))


@KINDS.add("effort changed", "C-JOINT")
def _(files: Files, rng: random.Random) -> Planted:
    joint = named_joint(files, rng, "[not(@type='ball')]")
    joint.set("actuatorfrcrange", "-1234 1234")
    return Planted(named("joint", joint), ("actuatorfrcrange",))


@KINDS.add("effort without limit", "C-JOINT")
def _(files: Files, rng: random.Random) -> Planted:
    joint = named_joint(files, rng, "[not(@type='ball')]")
    joint.set("actuatorfrclimited", "false")
    return Planted(named("joint", joint), ("actuatorfrcrange",))


@KINDS.add("spring in a joint", "C-JOINT")
def _(files: Files, rng: random.Random) -> Planted:
    joint = named_joint(files, rng)
    joint.set("stiffness", f"{rng.uniform(0.1, 10):.6g}")
    return Planted(named("joint", joint), ("stiffness",))


@KINDS.add("limit soft", "C-JOINT")
def _(files: Files, rng: random.Random) -> Planted:
    joint = named_joint(files, rng)
    put(joint, "solreflimit", (rng.uniform(0.1, 1), 1.0))
    return Planted(named("joint", joint), ("solreflimit",))


@KINDS.add("limit begins early", "C-JOINT")
def _(files: Files, rng: random.Random) -> Planted:
    joint = named_joint(files, rng)
    joint.set("margin", f"{rng.uniform(0.01, 0.3):.6g}")
    return Planted(named("joint", joint), ("margin",))


@KINDS.add("weight of a body taken off", "C-ACTUATOR")
def _(files: Files, rng: random.Random) -> Planted:
    body = moving_bodies(files, rng)
    body.set("gravcomp", "1")
    return Planted(named("body", body), ("gravcomp",))


@KINDS.add("joint type changed", "C-JOINT")
def _(files: Files, rng: random.Random) -> Planted:
    joint = named_joint(files, rng, "[not(@type='ball')]")
    sliding = "slide" in (joint.get("type") or "") + (joint.get("class") or "")
    joint.set("type", "hinge" if sliding else "slide")
    return Planted(named("joint", joint), ("type",))


@KINDS.add("body 1 mm off", "C-MOTION")
def _(files: Files, rng: random.Random) -> Planted:
    body = moving_bodies(files, rng)
    moved(body, "pos", rng, 0.001)
    return Planted(named("body", body), ("pos",))


@KINDS.add("quaternion with its real part last", "C-MOTION")
def _(files: Files, rng: random.Random) -> Planted:
    body = pick(files.mjcf.xpath("//worldbody/body//body[@quat][joint]"), rng)
    w, x, y, z = numbers(body, "quat")
    put(body, "quat", (x, y, z, w))
    return Planted(named("body", body), ("quat",))


@KINDS.add("body on another body", "C-MOTION")
def _(files: Files, rng: random.Random) -> Planted:
    deep = files.mjcf.xpath("//worldbody/body//body/body[joint]")
    body = pick(deep, rng)
    body.getparent().getparent().append(body)
    return Planted(named("body", body), ("parent", "pos"))


@KINDS.add("mass 1 % off", "C-MASS")
def _(files: Files, rng: random.Random) -> Planted:
    one = pick(files.mjcf.xpath("//body/inertial"), rng)
    one.set("mass", f"{float(one.get('mass')) * rng.choice((0.99, 1.01)):.12g}")
    return Planted(named("body", one.getparent()), ("inertial mass",))


@KINDS.add("mass in grams", "C-MASS", simcheck="grams as kilograms")
def _(files: Files, rng: random.Random) -> Planted:
    one = pick(files.mjcf.xpath("//body/inertial"), rng)
    one.set("mass", f"{float(one.get('mass')) * 1000:.12g}")
    return Planted(named("body", one.getparent()), ("inertial mass",))


@KINDS.add("inertial removed", "C-MASS", "C-COMPILE", simcheck="no inertial")
def _(files: Files, rng: random.Random) -> Planted:
    one = pick(files.mjcf.xpath("//body/inertial"), rng)
    body = one.getparent()
    body.remove(one)
    return Planted(named("body", body), ("inertial",))


@KINDS.add("centre of mass 2 mm off", "C-MASS")
def _(files: Files, rng: random.Random) -> Planted:
    one = pick(files.mjcf.xpath("//body/inertial"), rng)
    moved(one, "pos", rng, 0.002)
    return Planted(named("body", one.getparent()), ("inertial pos",))


@KINDS.add("axes of inertia turned the other way", "C-MASS")
def _(files: Files, rng: random.Random) -> Planted:
    one = pick(
        [
            one
            for one in files.mjcf.xpath("//body/inertial[@quat]")
            if 0.01 < abs(numbers(one, "quat")[0]) < 0.99
        ],
        rng,
    )
    w, *rest = numbers(one, "quat")
    put(one, "quat", (w, *sign_of(rest)))
    return Planted(named("body", one.getparent()), ("inertial quat", "inertial diaginertia"))


@KINDS.add("inertia in kg mm²", "C-MASS")
def _(files: Files, rng: random.Random) -> Planted:
    one = pick(files.mjcf.xpath("//body/inertial[@diaginertia]"), rng)
    put(one, "diaginertia", [1e6 * value for value in numbers(one, "diaginertia")])
    return Planted(named("body", one.getparent()), ("inertial diaginertia",))
